"""An inference engine with one network, in this process."""

import time
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np

from . import aliked, cases, ncnn_engine, networks, onnxruntime_engine, openvino_engine
from .cases import Case, ImageCase, Key, MatchingCase, Outputs

ENGINES: dict[str, ModuleType] = {
    "onnxruntime": onnxruntime_engine,
    "openvino": openvino_engine,
    "ncnn": ncnn_engine,
}
try:  # Only where it was asked for: with what it brings along it takes gigabytes.
    from . import torch_engine

    ENGINES["torch"] = torch_engine
except ImportError:
    pass

# What an engine's module must have for a network.
FUNCTIONS = {cases.SUPERGLUE: "graph_network"}


def runs(engine: str, case: Case) -> bool:
    return hasattr(ENGINES[engine], FUNCTIONS.get(case.kind, case.kind))


class Engine:
    """Its stages run one after the other, each on what the one before returned, after a pause so
    that none suffers from threads of another engine that still spin; their times are summed."""

    def __init__(
        self,
        stages: list[Callable[..., Any]],
        to_outputs: Callable[[Any], Outputs],
        pause_s: float,
        sinkhorn: str = "",
    ) -> None:
        self.sinkhorn = sinkhorn  # Whose it has, if any.
        self._stages = stages
        self._to_outputs = to_outputs
        self._pause_s = pause_s
        self._result: Any = None

    def measure(self) -> float:
        total_s = 0.0
        result: tuple[Any, ...] = ()
        for index, stage in enumerate(self._stages):
            if index > 0:
                time.sleep(self._pause_s)
            start = time.perf_counter()
            result = (stage(*result),)
            total_s += time.perf_counter() - start
        self._result = result[0]
        return total_s * 1e3

    def outputs(self) -> Outputs:
        self.measure()
        return self._to_outputs(self._result)


def make(case: Case, image: np.ndarray | None, key: Key, pause_s: float) -> Engine:
    """`image` [height, width], 0 to 255, of an ImageCase."""
    if isinstance(case, MatchingCase):
        return (_superglue if case.kind == cases.SUPERGLUE else _lightglue)(case, key, pause_s)
    assert image is not None
    makes = _superpoint if case.kind == cases.SUPERPOINT else _aliked
    return makes(case, image / np.float32(255), key, pause_s)


def _aliked(case: ImageCase, image: np.ndarray, key: Key, pause_s: float) -> Engine:
    module = ENGINES[key.engine]
    run = module.aliked(aliked.aliked(case.weights), image, key.precision, key.threads)

    def to_outputs(results: Any) -> Outputs:
        return {"score_map": np.squeeze(module.to_array(results[0]))}

    return Engine([run], to_outputs, pause_s)


def _lightglue(case: MatchingCase, key: Key, pause_s: float) -> Engine:
    module = ENGINES[key.engine]
    run = module.lightglue(case, key.precision, key.threads)
    return Engine([run], lambda result: {"log_assignment": module.to_array(result)}, pause_s)


def _superpoint(case: ImageCase, image: np.ndarray, key: Key, pause_s: float) -> Engine:
    module = ENGINES[key.engine]
    run = module.superpoint(case.weights, image, key.precision, key.threads)

    def to_outputs(results: Any) -> Outputs:
        logits, descriptors = (np.squeeze(module.to_array(value)) for value in results)
        probability = np.exp(logits - logits.max(axis=0))
        probability /= probability.sum(axis=0)
        _, height, width = logits.shape
        pixels = probability[:64].reshape(8, 8, height, width).transpose(2, 0, 3, 1)
        return {
            "score_map": pixels.reshape(8 * height, 8 * width),
            "descriptor_map": networks.make_golden.unit_length(descriptors, axis=0),
        }

    return Engine([run], to_outputs, pause_s)


def _superglue(case: MatchingCase, key: Key, pause_s: float) -> Engine:
    module = ENGINES[key.engine]
    graph = module.graph_network(case, key.precision, key.threads)
    if hasattr(module, "sinkhorn"):
        transport = module.sinkhorn(case, key.threads)
        stages: list[Callable[..., Any]] = [lambda: transport(graph())]
        last = module
    else:
        last, transport = _fastest_sinkhorn(case, key.threads, pause_s)
        stages = [graph, lambda scores: transport(module.to_array(scores))]

    def to_outputs(result: Any) -> Outputs:
        return {"log_assignment": last.to_array(result)}

    return Engine(stages, to_outputs, pause_s, last.NAME)


def _fastest_sinkhorn(
    case: MatchingCase, threads: int, pause_s: float
) -> tuple[ModuleType, Callable[..., Any]]:
    scores = np.zeros((case.count, case.count), np.float32)
    candidates = []
    for module in ENGINES.values():
        if hasattr(module, "sinkhorn"):
            run = module.sinkhorn(case, threads)
            times = []
            for _ in range(5):
                time.sleep(pause_s)
                start = time.perf_counter()
                run(scores)
                times.append(time.perf_counter() - start)
            candidates.append((min(times), module, run))
    _, module, run = min(candidates, key=lambda candidate: candidate[0])
    return module, run
