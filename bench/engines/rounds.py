"""Rounds in which every contestant runs once, and what else the machine did meanwhile."""

import dataclasses
import os
import pathlib
import random
import sys
import time
from collections.abc import Sequence

from .cases import Key
from .contestants import Contestant

TICKS_PER_S = os.sysconf("SC_CLK_TCK")
# How long others must be quiet before another round is tried.
LOOK_S = 1.0


@dataclasses.dataclass(frozen=True)
class Limits:
    rounds: int  # Wanted.
    foreign: float  # Processors that others may use in a round that counts.
    patience_s: float  # For rounds that do not count, and for waiting until the machine is quiet.
    pause_s: float  # Between two contestants.


@dataclasses.dataclass
class Record:
    times_ms: list[dict[Key, float]]  # A round each.
    discarded: int
    foreign: float  # The most processors that others used in a round that counts.


def _machine_s() -> float:
    """Processor time that was not idle; what the hypervisor gave to others counts."""
    words = pathlib.Path("/proc/stat").read_text().split("\n", 1)[0].split()
    user, nice, system, _idle, _wait, interrupts, soft, stolen = map(int, words[1:9])
    return (user + nice + system + interrupts + soft + stolen) / TICKS_PER_S


def _process_s(pid: int) -> float:
    # The name, in parentheses, may hold spaces.
    words = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / TICKS_PER_S


def _foreign_s(pids: Sequence[int]) -> float:
    return _machine_s() - sum(map(_process_s, pids))


class _Watch:
    """How much others use from its making on."""

    def __init__(self, pids: Sequence[int]) -> None:
        self._pids = pids
        self._start_s = time.perf_counter()
        self._used_s = _foreign_s(pids)

    def seconds(self) -> float:
        return time.perf_counter() - self._start_s

    def processors(self) -> float:
        return max(0.0, (_foreign_s(self._pids) - self._used_s) / self.seconds())


def run(contestants: Sequence[Contestant], limits: Limits) -> Record:
    pids = [os.getpid()] + [contestant.pid for contestant in contestants]
    for contestant in contestants:
        contestant.measure()
    record = Record([], 0, 0.0)
    order = list(contestants)
    generator = random.Random(1)
    impatience_s = 0.0
    while len(record.times_ms) < limits.rounds and impatience_s <= limits.patience_s:
        # Nobody always runs after the same one.
        generator.shuffle(order)
        watch = _Watch(pids)
        times_ms = {}
        for contestant in order:
            time.sleep(limits.pause_s)
            times_ms[contestant.key] = contestant.measure()
        foreign = watch.processors()
        is_quiet = foreign <= limits.foreign
        if is_quiet:
            record.times_ms.append(times_ms)
            record.foreign = max(record.foreign, foreign)
        else:
            record.discarded += 1
            impatience_s += watch.seconds()
        print(
            f"\r  {len(record.times_ms)} of {limits.rounds} rounds, {record.discarded} discarded "
            f"(in the last one others used {foreign:.2f} processors) ",
            end="",
            file=sys.stderr,
            flush=True,
        )
        while not is_quiet and impatience_s <= limits.patience_s:
            watch = _Watch(pids)
            time.sleep(LOOK_S)
            is_quiet = watch.processors() <= limits.foreign
            impatience_s += watch.seconds()
    print(file=sys.stderr)
    return record
