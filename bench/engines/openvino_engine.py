"""OpenVINO."""

from collections.abc import Callable

import numpy as np
import openvino
from openvino import opset8
from openvino.frontend import NodeContext
from openvino.frontend.onnx import ConversionExtension

from . import onnx_models, onnx_open_models
from .aliked import Aliked
from .cases import MatchingCase
from .networks import Tensors

NAME = "OpenVINO"
VERSION = openvino.__version__.split("-")[0]
_CORE = openvino.Core()
_HAS_BF16 = "BF16" in _CORE.get_property("CPU", "OPTIMIZATION_CAPABILITIES")
PRECISIONS = ("fp32", "bf16") if _HAS_BF16 else ("fp32",)
_HINTS = {"fp32": "f32", "bf16": "bf16"}


def _deformable(node: NodeContext) -> list[openvino.Output]:
    """Of ALIKED's ONNX model: OpenVINO has the operator, but its reader of ONNX does not know it."""
    data, weight, offsets, bias = (node.get_input(i) for i in range(4))
    ones, pads = [1, 1], [1, 1]
    convolved = opset8.deformable_convolution(
        data, offsets, weight, ones, pads, pads, ones, bilinear_interpolation_pad=True
    )
    shape = opset8.constant(np.array([1, -1, 1, 1]))
    return [opset8.add(convolved, opset8.reshape(bias, shape, False)).output(0)]


_CORE.add_extension(ConversionExtension("DeformConv", _deformable))


def _load(model: bytes, precision: str, threads: int) -> Callable[..., list[np.ndarray]]:
    # Without the hint it would take bf16 wherever the processor has it.
    settings = {
        "INFERENCE_PRECISION_HINT": _HINTS[precision],
        "INFERENCE_NUM_THREADS": threads,
        "PERFORMANCE_HINT": "LATENCY",
    }
    compiled = _CORE.compile_model(_CORE.read_model(model, b""), "CPU", settings)
    request = compiled.create_infer_request()

    def run(*inputs: np.ndarray) -> list[np.ndarray]:
        """The arrays are the engine's own, until the next call."""
        results = request.infer(list(inputs), share_inputs=True, share_outputs=True)
        return [results[i] for i in range(len(compiled.outputs))]

    return run


def superpoint(
    weights: Tensors, image: np.ndarray, precision: str, threads: int
) -> Callable[[], list[np.ndarray]]:
    run = _load(onnx_models.superpoint(weights, *image.shape), precision, threads)
    tensor = np.ascontiguousarray(image[None, None])
    return lambda: run(tensor)


def aliked(
    network: Aliked, image: np.ndarray, precision: str, threads: int
) -> Callable[[], list[np.ndarray]]:
    run = _load(onnx_open_models.aliked(network, *image.shape), precision, threads)
    tensor = np.ascontiguousarray(image[None, None])
    return lambda: run(tensor)


def lightglue(case: MatchingCase, precision: str, threads: int) -> Callable[[], np.ndarray]:
    form = onnx_models.Form(batched=True, fused_attention=False)
    run = _load(onnx_open_models.lightglue(case.network, case.count, form), precision, threads)
    return lambda: run(case.points, case.descriptors)[0]


def graph_network(case: MatchingCase, precision: str, threads: int) -> Callable[[], np.ndarray]:
    form = onnx_models.Form(batched=True, fused_attention=False)
    run = _load(onnx_models.superglue(case.network, case.count, form), precision, threads)
    return lambda: run(case.points, case.descriptors)[0]


def sinkhorn(case: MatchingCase, threads: int) -> Callable[[object], np.ndarray]:
    """In fp32 whatever the graph network has, as in gluevo."""
    run = _load(onnx_models.sinkhorn(case.count, case.network.dustbin), "fp32", threads)
    return lambda scores: run(np.asarray(scores))[0]


def to_array(value: np.ndarray) -> np.ndarray:
    return value.copy()
