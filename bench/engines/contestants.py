"""What is timed, each in a process of its own: gluevo and the engines."""

import multiprocessing
import pathlib
import subprocess
from multiprocessing.connection import Connection
from typing import Any, Protocol

import numpy as np

from . import cases, engine, networks
from .cases import Case, Key, Outputs

COMPARED = ("score_map", "descriptor_map", "log_assignment")
# Not a copy of this process, in which engines may have started threads.
_PROCESSES = multiprocessing.get_context("spawn")


class Contestant(Protocol):
    key: Key
    pid: int

    def measure(self) -> float:
        """Milliseconds of one call."""

    def outputs(self) -> Outputs: ...

    def close(self) -> None: ...


def reference(program: pathlib.Path, case: Case, folder: pathlib.Path) -> Outputs:
    """What gluevo computes in fp32, and what it read: an ImageCase's "image", 0 to 255."""
    output = folder / "gluevo_reference.safetensors"
    command = [str(program), "bench", "--rounds", "1", *case.gluevo_options()]
    command += ["--output", str(output)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return _without_dustbins(dict(networks.read(output)), case)


def _without_dustbins(outputs: Outputs, case: Case) -> Outputs:
    """LightGlue's engines leave out what says that a keypoint has no match."""
    if case.kind == cases.LIGHTGLUE:
        outputs["log_assignment"] = outputs["log_assignment"][:-1, :-1]
    return outputs


class Gluevo:
    """A process that keeps its network and runs it on request."""

    def __init__(self, program: pathlib.Path, case: Case, key: Key, folder: pathlib.Path) -> None:
        self.key = key
        self._case = case
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
        tensors = networks.read(self._output)
        outputs = {name: tensors[name] for name in COMPARED if name in tensors}
        return _without_dustbins(outputs, self._case)

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


class Engine:
    """An engine.Engine that runs on request."""

    def __init__(self, case: Case, image: np.ndarray | None, key: Key, pause_s: float) -> None:
        self.key = key
        self._connection, other_end = _PROCESSES.Pipe()
        self._process = _PROCESSES.Process(
            target=_serve, args=(other_end, case, image, key, pause_s), daemon=True
        )
        self._process.start()
        other_end.close()
        assert self._process.pid is not None
        self.pid = self._process.pid
        self.sinkhorn: str = self._receive()

    def measure(self) -> float:
        self._connection.send("measure")
        return self._receive()

    def outputs(self) -> Outputs:
        self._connection.send("outputs")
        return self._receive()

    def close(self) -> None:
        self._connection.close()
        self._process.join()

    def _receive(self) -> Any:
        try:
            return self._connection.recv()
        except EOFError:
            raise SystemExit(f"{self.key}: stopped") from None


def _serve(
    connection: Connection, case: Case, image: np.ndarray | None, key: Key, pause_s: float
) -> None:
    made = engine.make(case, image, key, pause_s)
    made.measure()
    connection.send(made.sinkhorn)
    try:
        while True:
            connection.send(made.measure() if connection.recv() == "measure" else made.outputs())
    except EOFError:
        pass
