"""What is timed: a network with weights and inputs, the same for all engines."""

import dataclasses
import pathlib

import numpy as np

from . import networks
from .networks import Tensors, make_golden

IMAGE_SEED = 3
WEIGHTS_SEED = 1
FEATURES_SEED = 2
SUPERPOINT = "superpoint"
SUPERGLUE = "superglue"


GLUEVO = "gluevo"
Outputs = dict[str, np.ndarray]  # By the names of tests/golden/README.md.


@dataclasses.dataclass(frozen=True)
class Key:
    engine: str  # A name of engine.ENGINES, or GLUEVO.
    precision: str
    threads: int


@dataclasses.dataclass(frozen=True)
class SuperPointCase:
    name: str
    weights_file: pathlib.Path
    image_file: pathlib.Path
    weights: Tensors

    def gluevo_options(self) -> list[str]:
        files = ["--superpoint", str(self.weights_file), "--image", str(self.image_file)]
        return ["--network", SUPERPOINT, *files]


@dataclasses.dataclass(frozen=True)
class SuperGlueCase:
    name: str
    weights_file: pathlib.Path
    features_file: pathlib.Path
    network: networks.SuperGlue
    points: np.ndarray  # [2, N, 3] float32: of each image x and y, normalised, and score.
    descriptors: np.ndarray  # [2, N, D] float32.

    def gluevo_options(self) -> list[str]:
        files = ["--superglue", str(self.weights_file), "--features", str(self.features_file)]
        return ["--network", SUPERGLUE, *files]

    @property
    def count(self) -> int:
        return self.points.shape[1]


Case = SuperPointCase | SuperGlueCase


def write_npz(path: pathlib.Path, tensors: Tensors) -> pathlib.Path:
    np.savez(path, **dict(tensors))
    return path


def superpoint(
    folder: pathlib.Path,
    weights_file: pathlib.Path | None,
    image_file: pathlib.Path | None,
    size: tuple[int, int],
) -> SuperPointCase:
    """Where no file is given, random weights and a synthetic image of `size` (width, height), which
    this writes into `folder`."""
    if weights_file is None:
        random = networks.random_superpoint(WEIGHTS_SEED)
        weights_file = write_npz(folder / "superpoint_random.npz", random)
    weights = networks.read(weights_file)
    if any(name.endswith(".scale") for name in weights):
        raise SystemExit(f"{weights_file}: batch normalisation after activations is not supported")
    name = f"SuperPoint {size[0]}x{size[1]}"
    if image_file is None:
        image = make_golden.synthetic_image(*size, IMAGE_SEED)
        image_file = folder / "image.pgm"
        image_file.write_bytes(b"P5\n%d %d\n255\n" % size + image.tobytes())
    else:
        name = f"SuperPoint, {image_file.name}"
    return SuperPointCase(name, weights_file, image_file, weights)


def superglue(
    folder: pathlib.Path, weights_file: pathlib.Path | None, count: int, size: tuple[int, int]
) -> SuperGlueCase:
    """Two images of `size` (width, height) with `count` keypoints each, the second's being the
    first's, moved and with noise. Random weights where no file is given. Writes into `folder`."""
    if weights_file is None:
        random = networks.random_superglue(WEIGHTS_SEED)
        weights_file = write_npz(folder / "superglue_random.npz", random)
    network = networks.superglue(networks.read(weights_file))

    rng = np.random.default_rng(FEATURES_SEED)
    features = make_golden.random_features(rng, count, network.width, size)
    noise = rng.standard_normal((count, network.width)) * (0.3 / network.width**0.5)
    moved = {
        "keypoints": features["keypoints"] + rng.uniform(-3, 3, (count, 2)),
        "scores": features["scores"],
        "descriptors": make_golden.unit_length(features["descriptors"] + noise, axis=1),
        "size": features["size"],
    }
    images = [
        {key: np.asarray(value, np.float32) for key, value in image.items()}
        for image in (features, moved)
    ]
    named = {f"{key}{i}": value for i, image in enumerate(images) for key, value in image.items()}
    features_file = write_npz(folder / f"features_{count}.npz", named)
    points = [
        np.column_stack([(i["keypoints"] - i["size"] / 2) / (0.7 * i["size"].max()), i["scores"]])
        for i in images
    ]
    return SuperGlueCase(
        f"SuperGlue, {len(network.layers)} layers, {count} keypoints",
        weights_file,
        features_file,
        network,
        np.stack(points).astype(np.float32),
        np.stack([image["descriptors"] for image in images]),
    )
