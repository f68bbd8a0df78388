"""Whether all compute the same."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from .cases import SUPERGLUE, SUPERPOINT, Key, Outputs
from .networks import make_golden

# Relative RMS. In fp32 either may err by what tests/nn/golden.h derives for whole networks, 300
# units of 2^-24. bf16 errs by more than a small mistake in a network would: there fp32 tells
# whether the network is the same, and this whether the result is of use.
TOLERANCE = {"fp32": 2 * 300 * 2.0**-24, "bf16": 0.1}
# gluevo's own bound is half of that.
CONFIDENCE_TOLERANCE = 2e-4
KEYPOINTS = 500
THRESHOLD = 0.005


@dataclasses.dataclass(frozen=True)
class Agreement:
    differences: dict[str, float]  # Relative RMS, of each output.
    confidence: float | None  # Largest difference of a pair's confidence.
    keypoints: float | None  # Share of the best ones that are found at the same pixel.

    def within(self, precision: str) -> bool:
        pairs = [(value, TOLERANCE[precision]) for value in self.differences.values()]
        if precision == "fp32" and self.confidence is not None:
            pairs.append((self.confidence, CONFIDENCE_TOLERANCE))
        return all(value <= bound for value, bound in pairs)  # NaN is not within.


def compare(outputs: Outputs, expected: Outputs, kind: str) -> Agreement:
    """With gluevo's in fp32; `kind` of the case."""
    differences = {name: _relative_rms(outputs[name], expected[name]) for name in outputs}
    confidence = None
    keypoints = None
    if "log_assignment" in expected:
        end = -1 if kind == SUPERGLUE else None  # Without its dustbins.
        pairs = [np.exp(o["log_assignment"][:end, :end]) for o in (outputs, expected)]
        confidence = float(np.abs(pairs[0] - pairs[1]).max())
    elif kind == SUPERPOINT:
        found, wanted = (_best_keypoints(o["score_map"]) for o in (outputs, expected))
        keypoints = len(found & wanted) / len(wanted) if wanted else 1.0
    return Agreement(differences, confidence, keypoints)


def _relative_rms(actual: np.ndarray, expected: np.ndarray) -> float:
    if actual.shape != expected.shape:
        raise SystemExit(f"an output of shape {actual.shape}, expected {expected.shape}")
    difference = actual.astype(np.float64) - expected
    return float(np.linalg.norm(difference) / np.linalg.norm(expected.astype(np.float64)))


def _best_keypoints(score_map: np.ndarray) -> set[tuple[int, int]]:
    keypoints, scores = make_golden.select_keypoints(score_map, THRESHOLD)
    best = np.argsort(-scores, kind="stable")[:KEYPOINTS]
    return {(int(x), int(y)) for x, y in keypoints[best]}


def describe(agreements: Mapping[Key, Agreement], name: Mapping[str, str]) -> list[str]:
    """Lines of Markdown."""
    lines = []
    for key, agreement in agreements.items():
        parts = [f"{what} {value:.1e}" for what, value in agreement.differences.items()]
        if agreement.confidence is not None:
            parts.append(f"confidences {agreement.confidence:.1e}")
        if agreement.keypoints is not None:
            parts.append(
                f"the same {100 * agreement.keypoints:.1f} % of the best {KEYPOINTS} keypoints"
            )
        lines.append(f"{name[key.engine]} {key.precision}: {', '.join(parts)}")
    return lines
