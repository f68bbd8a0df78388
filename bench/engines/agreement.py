"""Whether all compute the same."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from .contestants import Key, Outputs
from .networks import make_golden

# Each may be off by 1e-4 of the exact values, gluevo's bound for its own outputs. bf16 has 8 bits:
# there this only tells that the networks are the same.
TOLERANCE = {"fp32": 2e-4, "bf16": 0.2}
KEYPOINTS = 500
THRESHOLD = 0.005


@dataclasses.dataclass(frozen=True)
class Agreement:
    differences: dict[str, float]  # Relative RMS, of each output.
    confidence: float | None  # Largest difference of a pair's confidence.
    keypoints: float | None  # Share of the best ones that are found at the same pixel.

    def within(self, precision: str) -> bool:
        worst = max(self.differences.values())
        if precision == "fp32" and self.confidence is not None:
            worst = max(worst, self.confidence)
        return worst <= TOLERANCE[precision]


def compare(outputs: Outputs, expected: Outputs) -> Agreement:
    """With gluevo's in fp32."""
    names = [name for name in ("score_map", "descriptor_map", "log_assignment") if name in expected]
    differences = {name: _relative_rms(outputs[name], expected[name]) for name in names}
    confidence = None
    keypoints = None
    if "log_assignment" in expected:
        pairs = [np.exp(o["log_assignment"][:-1, :-1]) for o in (outputs, expected)]
        confidence = float(np.abs(pairs[0] - pairs[1]).max())
    else:
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
            parts.append(f"a confidence {agreement.confidence:.1e} (absolute, at most)")
        if agreement.keypoints is not None:
            parts.append(
                f"{100 * agreement.keypoints:.1f} % of the best {KEYPOINTS} keypoints the same"
            )
        lines.append(f"{name[key.engine]} {key.precision}: {', '.join(parts)}")
    return lines
