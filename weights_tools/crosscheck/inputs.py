"""Inputs that every check runs on, and what is written for the tests."""

import numpy as np
import torch
from safetensors.torch import save_file


def image(height, width, seed=1):
    """Gray levels 0 to 255 of overlapping rectangles, with sharp corners up to the borders."""
    random = np.random.default_rng(seed)
    pixels = np.full((height, width), 100, np.uint8)
    for _ in range(height * width // 60):
        y, x = random.integers(-4, height), random.integers(-4, width)
        h, w = random.integers(3, 14, 2)
        pixels[max(y, 0) : max(y + h, 0), max(x, 0) : max(x + w, 0)] = random.integers(0, 256)
    return pixels


def features(count, size, width, height, seed=2):
    """Keypoints in pixels, scores and unit descriptors of an image, and the same points in another
    order, a little moved, of another image: (keypoints, scores, descriptors) twice."""
    random = np.random.default_rng(seed)
    keypoints = random.uniform(4, [width - 4, height - 4], (count, 2))
    scores = random.uniform(0.01, 0.9, count)
    descriptors = random.standard_normal((count, size))
    order = random.permutation(count)
    other = (
        np.clip(keypoints[order] + random.normal(3, 1, (count, 2)), 0, [width - 1, height - 1]),
        random.uniform(0.01, 0.9, count),
        descriptors[order] + 0.3 * random.standard_normal((count, size)),
    )

    def to_torch(points, confidence, vectors):
        vectors = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
        return [torch.tensor(a, dtype=torch.float32) for a in (points, confidence, vectors)]

    return to_torch(keypoints, scores, descriptors), to_torch(*other)


def save_superpoint_golden(path, pixels, scores, descriptors):
    save_file(
        {
            "image": torch.tensor(pixels, dtype=torch.float32),
            "scores": scores.float().contiguous(),
            "descriptors": descriptors.float().contiguous(),
        },
        path,
    )


def save_superglue_golden(path, width, height, first, second, assignment):
    tensors = {"size": torch.tensor([width, height], dtype=torch.float32)}
    for i, (keypoints, scores, descriptors) in enumerate((first, second)):
        tensors |= {
            f"keypoints{i}": keypoints,
            f"scores{i}": scores,
            f"descriptors{i}": descriptors,
        }
    tensors["log_assignment"] = assignment.float()
    save_file({name: value.contiguous() for name, value in tensors.items()}, path)
