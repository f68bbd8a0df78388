"""The Markdown that the comparison prints."""

import statistics
from collections.abc import Sequence

from .agreement import CONFIDENCE_TOLERANCE, TOLERANCE
from .cases import GLUEVO, Key
from .engine import ENGINES
from .networks import SINKHORN_ITERATIONS
from .rounds import Record

NAMES = {GLUEVO: "gluevo"} | {key: module.NAME for key, module in ENGINES.items()}

EXPLANATION = f"""
An engine's column is its time over gluevo's in the same round: the median (least to most) of the
rounds, above 1 where gluevo is faster; bold is the fastest engine. The last column is gluevo's time
with one thread over its time with the row's. SuperPoint and ALIKED: gluevo goes from the image to
keypoints and descriptors, the engines compute the dense network alone. SuperGlue: graph network and
{SINKHORN_ITERATIONS} Sinkhorn iterations, which the engines do in the log domain with one
exponential an entry and iteration.
"""
AGREEMENT_EXPLANATION = f"""
Difference from gluevo in fp32: relative RMS of each output (bounds: {TOLERANCE["fp32"]:.1e} in
fp32, {TOLERANCE["bf16"]} in bf16), largest difference of a confidence (bound in fp32:
{CONFIDENCE_TOLERANCE}), and keypoints:
"""


def _summary(values: Sequence[float], digits: int) -> str:
    low, middle, high = min(values), statistics.median(values), max(values)
    return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def _ratios(record: Record, over: Key, under: Key) -> list[float]:
    return [times[over] / times[under] for times in record.times_ms]


def least(record: Record) -> str:
    """Of a busy machine: what each takes when nothing is in its way."""
    measured = record.times_ms[0].keys() if record.times_ms else []
    lows = {key: min(times[key] for times in record.times_ms) for key in measured}
    parts = []
    for key, low in lows.items():
        ours = lows[Key(GLUEVO, key.precision, key.threads)]
        over = "" if key.engine == GLUEVO else f" ({low / ours:.2f} times gluevo's)"
        parts.append(f"{NAMES[key.engine]} {key.precision}, {key.threads} threads {low:.1f} ms{over}")
    return "; ".join(parts)


def header(engines: Sequence[str]) -> list[str]:
    titles = ["work", "threads", "gluevo, ms"]
    titles += [f"{NAMES[engine]} {ENGINES[engine].VERSION}" for engine in engines]
    titles += ["gluevo's gain by threads"]
    return ["| " + " | ".join(titles) + " |", "| --- " * len(titles) + "|"]


def rows(
    name: str, record: Record, engines: Sequence[str], precisions: Sequence[str], threads: list[int]
) -> list[str]:
    """Of one case: a line for each precision and number of threads."""
    lines = []
    measured = record.times_ms[0].keys() if record.times_ms else set()
    for precision in precisions:
        for count in threads:
            ours = Key(GLUEVO, precision, count)
            if ours not in measured:
                continue
            ratios = {
                engine: _ratios(record, Key(engine, precision, count), ours)
                for engine in engines
                if Key(engine, precision, count) in measured
            }
            fastest = min(ratios, key=lambda engine: statistics.median(ratios[engine]), default="")
            cells = [f"{name}, {precision}", str(count)]
            cells.append(_summary([times[ours] for times in record.times_ms], 1))
            for engine in engines:
                text = _summary(ratios[engine], 2) if engine in ratios else "-"
                cells.append(f"**{text}**" if engine == fastest else text)
            alone = Key(GLUEVO, precision, 1)
            has_gain = count > 1 and alone in measured
            cells.append(_summary(_ratios(record, alone, ours), 2) if has_gain else "-")
            lines.append("| " + " | ".join(cells) + " |")
    return lines
