"""ncnn. It has no form of Sinkhorn's algorithm but one layer an operation, so that another engine's
stands in."""

import importlib.metadata
import pathlib
import tempfile
from collections.abc import Callable

import ncnn
import numpy as np

from . import ncnn_models
from .cases import MatchingCase
from .networks import Tensors

NAME = "ncnn"
VERSION = importlib.metadata.version("ncnn")
PRECISIONS = ("fp32", "bf16")


def _load(
    model: tuple[ncnn_models.Net, list[str]],
    inputs: dict[str, np.ndarray],
    precision: str,
    threads: int,
) -> Callable[[], list[ncnn.Mat]]:
    description, outputs = model
    net = ncnn.Net()
    net.opt.num_threads = threads
    net.opt.use_fp16_packed = net.opt.use_fp16_storage = net.opt.use_fp16_arithmetic = False
    net.opt.use_bf16_packed = net.opt.use_bf16_storage = precision == "bf16"
    with tempfile.TemporaryDirectory() as name:
        parameters, weights = (pathlib.Path(name) / file for file in ("net.param", "net.bin"))
        parameters.write_text(description.parameters())
        weights.write_bytes(description.weights())
        if net.load_param(str(parameters)) != 0 or net.load_model(str(weights)) != 0:
            raise RuntimeError("ncnn does not load the network")
    # An ncnn.Mat borrows the memory of the array that it is made of.
    arrays = {blob: np.ascontiguousarray(array) for blob, array in inputs.items()}

    def run() -> list[ncnn.Mat]:
        extractor = net.create_extractor()
        for blob, array in arrays.items():
            extractor.input(blob, ncnn.Mat(array))
        results = [extractor.extract(blob) for blob in outputs]
        if any(code != 0 for code, _ in results):
            raise RuntimeError("ncnn does not run the network")
        return [mat for _, mat in results]

    return run


def superpoint(
    weights: Tensors, image: np.ndarray, precision: str, threads: int
) -> Callable[[], list[ncnn.Mat]]:
    return _load(ncnn_models.superpoint(weights), {"image": image[None]}, precision, threads)


def graph_network(case: MatchingCase, precision: str, threads: int) -> Callable[[], ncnn.Mat]:
    inputs = dict(zip(ncnn_models.POINTS, case.points))
    inputs |= zip(ncnn_models.DESCRIPTORS, case.descriptors)
    run = _load(ncnn_models.superglue(case.network), inputs, precision, threads)
    return lambda: run()[0]


def to_array(value: ncnn.Mat) -> np.ndarray:
    return np.array(value)
