"""One engine with one network, ready to be timed."""

import dataclasses
import pathlib
import subprocess
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any, Protocol

import numpy as np

from . import ncnn_engine, networks, onnxruntime_engine, openvino_engine
from .cases import Case, SuperGlueCase, SuperPointCase

GLUEVO = "gluevo"
ENGINES: dict[str, ModuleType] = {
    "onnxruntime": onnxruntime_engine,
    "openvino": openvino_engine,
    "ncnn": ncnn_engine,
}
Outputs = dict[str, np.ndarray]  # By the names of tests/golden/README.md.


@dataclasses.dataclass(frozen=True)
class Key:
    engine: str  # A name of ENGINES, or GLUEVO.
    precision: str
    threads: int


class Contestant(Protocol):
    key: Key

    def measure(self) -> float:
        """Milliseconds of one call."""

    def outputs(self) -> Outputs: ...

    def close(self) -> None: ...


def reference(program: pathlib.Path, case: Case, folder: pathlib.Path) -> Outputs:
    """What gluevo computes in fp32, and what it read: SuperPoint's "image", 0 to 255."""
    output = folder / "gluevo_reference.safetensors"
    command = [str(program), "bench", "--rounds", "1", *case.gluevo_options()]
    command += ["--output", str(output)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return dict(networks.read(output))


class Gluevo:
    """A process that keeps its network and runs it on request."""

    def __init__(self, program: pathlib.Path, case: Case, key: Key, folder: pathlib.Path) -> None:
        self.key = key
        self._output = folder / f"gluevo_{key.precision}_{key.threads}.safetensors"
        command = [str(program), "bench", "--on-request", *case.gluevo_options()]
        command += ["--threads", str(key.threads), "--output", str(self._output)]
        if key.precision != "fp32":
            command += ["--precision", key.precision]
        self._command = " ".join(command)
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.pid = self._process.pid

    def measure(self) -> float:
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        answer = self._process.stdout.readline()
        if not answer:
            raise SystemExit(f"{self._command}: stopped")
        return float(answer)

    def outputs(self) -> Outputs:
        self.measure()  # The file is there before the first answer.
        return dict(networks.read(self._output))

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


class Engine:
    """An inference engine in this process. Its stages run one after the other, each on what the one
    before returned, after a pause so that none suffers from threads of another engine that still
    spin; their times are summed."""

    def __init__(
        self,
        key: Key,
        stages: list[Callable[..., Any]],
        to_outputs: Callable[[Any], Outputs],
        pause_s: float,
    ) -> None:
        self.key = key
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

    def close(self) -> None:
        self._stages = []
        self._result = None


def superpoint_engine(case: SuperPointCase, image: np.ndarray, key: Key, pause_s: float) -> Engine:
    """`image` [height, width], 0 to 255."""
    module = ENGINES[key.engine]
    run = module.superpoint(case.weights, image / np.float32(255), key.precision, key.threads)

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

    return Engine(key, [run], to_outputs, pause_s)


def superglue_engine(case: SuperGlueCase, key: Key, pause_s: float) -> tuple[Engine, str]:
    """And whose Sinkhorn it has."""
    module = ENGINES[key.engine]
    graph = module.graph_network(case, key.precision, key.threads)
    if hasattr(module, "sinkhorn"):
        transport = module.sinkhorn(case, key.threads)
        stages: list[Callable[..., Any]] = [lambda: transport(graph())]
        last = module
    else:
        last, transport = fastest_sinkhorn(case, key.threads, pause_s)
        stages = [graph, lambda scores: transport(module.to_array(scores))]

    def to_outputs(result: Any) -> Outputs:
        return {"log_assignment": last.to_array(result)}

    return Engine(key, stages, to_outputs, pause_s), last.NAME


def fastest_sinkhorn(
    case: SuperGlueCase, threads: int, pause_s: float
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
