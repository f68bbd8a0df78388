"""ONNX Runtime."""

from collections.abc import Callable

import numpy as np
import onnxruntime
from onnxruntime import OrtValue

from . import onnx_models, onnx_open_models
from .aliked import Aliked
from .cases import MatchingCase
from .networks import Tensors

NAME = "ONNX Runtime"
VERSION = onnxruntime.__version__
PRECISIONS = ("fp32",)
ERRORS_ONLY = 3


def _load(model: bytes, threads: int) -> onnxruntime.InferenceSession:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.log_severity_level = ERRORS_ONLY
    return onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])


def _value(array: np.ndarray) -> OrtValue:
    return OrtValue.ortvalue_from_numpy(np.ascontiguousarray(array))


def superpoint(
    weights: Tensors, image: np.ndarray, precision: str, threads: int
) -> Callable[[], list[OrtValue]]:
    session = _load(onnx_models.superpoint(weights, *image.shape), threads)
    inputs = {"image": _value(image[None, None])}
    return lambda: session.run_with_ort_values(["logits", "descriptors"], inputs)


def aliked(
    network: Aliked, image: np.ndarray, precision: str, threads: int
) -> Callable[[], list[OrtValue]]:
    session = _load(onnx_open_models.aliked(network, *image.shape), threads)
    inputs = {"image": _value(image[None, None])}
    return lambda: session.run_with_ort_values(["score_map", "feature_map"], inputs)


def lightglue(case: MatchingCase, precision: str, threads: int) -> Callable[[], OrtValue]:
    form = onnx_models.Form(batched=False, fused_attention=True)
    session = _load(onnx_open_models.lightglue(case.network, case.count, form), threads)
    inputs = {"points": _value(case.points), "descriptors": _value(case.descriptors)}
    return lambda: session.run_with_ort_values(["log_assignment"], inputs)[0]


def graph_network(case: MatchingCase, precision: str, threads: int) -> Callable[[], OrtValue]:
    form = onnx_models.Form(batched=False, fused_attention=True)
    session = _load(onnx_models.superglue(case.network, case.count, form), threads)
    inputs = {"points": _value(case.points), "descriptors": _value(case.descriptors)}
    return lambda: session.run_with_ort_values(["scores"], inputs)[0]


def sinkhorn(case: MatchingCase, threads: int) -> Callable[[object], OrtValue]:
    session = _load(onnx_models.sinkhorn(case.count, case.network.dustbin), threads)

    def run(scores: object) -> OrtValue:
        value = scores if isinstance(scores, OrtValue) else _value(np.asarray(scores))
        return session.run_with_ort_values(["log_assignment"], {"scores": value})[0]

    return run


def to_array(value: OrtValue) -> np.ndarray:
    return value.numpy()
