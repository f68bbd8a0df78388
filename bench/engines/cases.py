"""What is timed: a network with weights and inputs, the same for all engines."""

import dataclasses
import pathlib

import numpy as np

from . import aliked as aliked_weights
from . import lightglue as lightglue_weights
from . import networks
from .networks import Tensors, make_golden

IMAGE_SEED = 3
WEIGHTS_SEED = 1
FEATURES_SEED = 2
SUPERPOINT = "superpoint"
SUPERGLUE = "superglue"
ALIKED = "aliked"
LIGHTGLUE = "lightglue"
ALL = (SUPERPOINT, SUPERGLUE, ALIKED, LIGHTGLUE)


GLUEVO = "gluevo"
Outputs = dict[str, np.ndarray]  # By the names of tests/golden/README.md.


@dataclasses.dataclass(frozen=True)
class Key:
    engine: str  # A name of engine.ENGINES, or GLUEVO.
    precision: str
    threads: int


@dataclasses.dataclass(frozen=True)
class ImageCase:
    """SuperPoint, or ALIKED."""

    kind: str
    name: str
    weights_file: pathlib.Path
    image_file: pathlib.Path
    weights: Tensors

    def gluevo_options(self) -> list[str]:
        files = [f"--{self.kind}", str(self.weights_file), "--image", str(self.image_file)]
        return ["--network", self.kind, *files]


@dataclasses.dataclass(frozen=True)
class MatchingCase:
    """SuperGlue, or LightGlue with all its layers."""

    kind: str
    name: str
    weights_file: pathlib.Path
    features_file: pathlib.Path
    network: networks.SuperGlue | lightglue_weights.LightGlue
    # [2, N, 3] float32: of each image x and y, normalised, and score; LightGlue's without score.
    points: np.ndarray
    descriptors: np.ndarray  # [2, N, D] float32.

    def gluevo_options(self) -> list[str]:
        files = [f"--{self.kind}", str(self.weights_file), "--features", str(self.features_file)]
        whole = ["--depth-confidence", "0", "--width-confidence", "0"]
        return ["--network", self.kind, *files, *(whole if self.kind == LIGHTGLUE else [])]

    @property
    def count(self) -> int:
        return self.points.shape[1]


Case = ImageCase | MatchingCase


def write_npz(path: pathlib.Path, tensors: Tensors) -> pathlib.Path:
    np.savez(path, **dict(tensors))
    return path


def superpoint(
    folder: pathlib.Path,
    weights_file: pathlib.Path | None,
    image_file: pathlib.Path | None,
    size: tuple[int, int],
) -> ImageCase:
    """Where no file is given, random weights and a synthetic image of `size` (width, height), which
    this writes into `folder`."""
    if weights_file is None:
        random = networks.random_superpoint(WEIGHTS_SEED)
        weights_file = write_npz(folder / "superpoint_random.npz", random)
    weights = networks.read(weights_file)
    if any(name.endswith(".scale") for name in weights):
        raise SystemExit(f"{weights_file}: batch normalisation after activations is not supported")
    return _of_image(SUPERPOINT, "SuperPoint", folder, weights_file, weights, image_file, size)


def aliked(
    folder: pathlib.Path,
    weights_file: pathlib.Path | None,
    image_file: pathlib.Path | None,
    size: tuple[int, int],
) -> ImageCase:
    """As superpoint."""
    if weights_file is None:
        random = aliked_weights.random_aliked(WEIGHTS_SEED)
        weights_file = write_npz(folder / "aliked_random.npz", random)
    weights = networks.read(weights_file)
    return _of_image(ALIKED, "ALIKED", folder, weights_file, weights, image_file, size)


def _of_image(
    kind: str,
    name: str,
    folder: pathlib.Path,
    weights_file: pathlib.Path,
    weights: Tensors,
    image_file: pathlib.Path | None,
    size: tuple[int, int],
) -> ImageCase:
    if image_file is not None:
        return ImageCase(kind, f"{name}, {image_file.name}", weights_file, image_file, weights)
    image = make_golden.synthetic_image(*size, IMAGE_SEED)
    image_file = folder / "image.pgm"
    image_file.write_bytes(b"P5\n%d %d\n255\n" % size + image.tobytes())
    return ImageCase(kind, f"{name} {size[0]}x{size[1]}", weights_file, image_file, weights)


def superglue(
    folder: pathlib.Path, weights_file: pathlib.Path | None, count: int, size: tuple[int, int]
) -> MatchingCase:
    """Two images of `size` (width, height) with `count` keypoints each, the second's being the
    first's, moved and with noise. Random weights where no file is given. Writes into `folder`."""
    if weights_file is None:
        random = networks.random_superglue(WEIGHTS_SEED)
        weights_file = write_npz(folder / "superglue_random.npz", random)
    network = networks.superglue(networks.read(weights_file))
    images, features_file = _two_images(folder, count, network.width, size)
    points = [
        np.column_stack([(i["keypoints"] - i["size"] / 2) / (0.7 * i["size"].max()), i["scores"]])
        for i in images
    ]
    name = f"SuperGlue, {len(network.layers)} layers, {count} keypoints"
    return _of_pair(SUPERGLUE, name, weights_file, features_file, network, points, images)


def lightglue(
    folder: pathlib.Path, weights_file: pathlib.Path | None, count: int, size: tuple[int, int]
) -> MatchingCase:
    """As superglue."""
    if weights_file is None:
        random = lightglue_weights.random_lightglue(WEIGHTS_SEED)
        weights_file = write_npz(folder / "lightglue_random.npz", random)
    network = lightglue_weights.lightglue(networks.read(weights_file))
    images, features_file = _two_images(folder, count, network.descriptor_size, size)
    points = [(i["keypoints"] - i["size"] / 2) / (i["size"].max() / 2) for i in images]
    name = f"LightGlue, all {len(network.layers)} layers, {count} keypoints"
    return _of_pair(LIGHTGLUE, name, weights_file, features_file, network, points, images)


def _of_pair(
    kind: str,
    name: str,
    weights_file: pathlib.Path,
    features_file: pathlib.Path,
    network: networks.SuperGlue | lightglue_weights.LightGlue,
    points: list[np.ndarray],
    images: list[dict[str, np.ndarray]],
) -> MatchingCase:
    descriptors = np.stack([image["descriptors"] for image in images])
    both = np.stack(points).astype(np.float32)
    return MatchingCase(kind, name, weights_file, features_file, network, both, descriptors)


def _two_images(
    folder: pathlib.Path, count: int, descriptor_size: int, size: tuple[int, int]
) -> tuple[list[dict[str, np.ndarray]], pathlib.Path]:
    rng = np.random.default_rng(FEATURES_SEED)
    features = make_golden.random_features(rng, count, descriptor_size, size)
    noise = rng.standard_normal((count, descriptor_size)) * (0.3 / descriptor_size**0.5)
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
    return images, write_npz(folder / f"features_{count}_{descriptor_size}.npz", named)
