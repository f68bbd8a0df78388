"""Rounds in which every contestant runs once, and what else the machine did meanwhile."""

import dataclasses
import os
import pathlib
import random
import sys
import time
from collections.abc import Sequence

from .contestants import Contestant, Gluevo, Key

TICKS_PER_S = os.sysconf("SC_CLK_TCK")


@dataclasses.dataclass(frozen=True)
class Limits:
    rounds: int  # Wanted.
    most_rounds: int  # Tried.
    foreign: float  # Processors that others may use in a round that counts.
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


def run(contestants: Sequence[Contestant], limits: Limits) -> Record:
    pids = [os.getpid()] + [c.pid for c in contestants if isinstance(c, Gluevo)]
    for contestant in contestants:
        contestant.measure()
    record = Record([], 0, 0.0)
    order = list(contestants)
    generator = random.Random(1)
    for number in range(limits.most_rounds):
        # Nobody always runs after the same one.
        generator.shuffle(order)
        start_s = time.perf_counter()
        foreign_before_s = _foreign_s(pids)
        times_ms = {}
        for contestant in order:
            time.sleep(limits.pause_s)
            times_ms[contestant.key] = contestant.measure()
        used_s = _foreign_s(pids) - foreign_before_s
        foreign = max(0.0, used_s / (time.perf_counter() - start_s))
        if foreign > limits.foreign:
            record.discarded += 1
        else:
            record.times_ms.append(times_ms)
            record.foreign = max(record.foreign, foreign)
        print(
            f"\r  round {number + 1}: {len(record.times_ms)} of {limits.rounds}, "
            f"{record.discarded} discarded (others now use {foreign:.2f} processors) ",
            end="",
            file=sys.stderr,
            flush=True,
        )
        if len(record.times_ms) == limits.rounds:
            break
    print(file=sys.stderr)
    return record
