"""The weights of both networks as plain matrices, as every engine takes them."""

import dataclasses
import pathlib
import sys
from collections.abc import Iterator, Mapping

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "golden"))
import make_golden as make_golden  # noqa: E402

Tensors = Mapping[str, np.ndarray]

HEADS = make_golden.HEADS
SINKHORN_ITERATIONS = make_golden.SINKHORN_ITERATIONS
# Of the published SuperPoint: channels of the layers a and b of each stage.
TRUNK = {"1": 64, "2": 64, "3": 128, "4": 128}
POOLED = ("conv1b", "conv2b", "conv3b")


def read(path: pathlib.Path) -> Tensors:
    """A .safetensors or .npz file, in float32."""
    if path.suffix == ".npz":
        with np.load(path) as file:
            return {name: np.asarray(file[name], np.float32) for name in file.files}
    tensors = make_golden.read_safetensors(path)
    return {name: values.astype(np.float32) for name, values in tensors.items()}


def random_superpoint(seed: int) -> Tensors:
    """Of the published shape; activations keep their size from layer to layer (He et al. 2015)."""
    rng = np.random.default_rng(seed)
    weights: dict[str, np.ndarray] = {}

    def add(name: str, inputs: int, outputs: int, size: int) -> int:
        scale = np.sqrt(2.0 / (inputs * size * size))
        shape = (outputs, inputs, size, size)
        weights[name + ".weight"] = (rng.standard_normal(shape) * scale).astype(np.float32)
        weights[name + ".bias"] = (rng.standard_normal(outputs) * 0.05).astype(np.float32)
        return outputs

    channels = 1
    for stage, outputs in TRUNK.items():
        for part in "ab":
            channels = add(f"conv{stage}{part}", channels, outputs, 3)
    for head, outputs in (("P", 65), ("D", 256)):
        add(f"conv{head}b", add(f"conv{head}a", channels, 256, 3), outputs, 1)
    return weights


def random_superglue(seed: int) -> Tensors:
    """Of the published shape: 18 layers of width 256, keypoint encoder 3-32-64-128-256-256."""
    weights = make_golden.random_superglue(seed, 256, [32, 64, 128, 256], 18)
    # As they come, the scores of 18 layers reach tens of thousands; so scaled, a few tens, and the
    # keypoints that belong together match.
    scales = {"kenc.encoder.12.": 0.05, ".mlp.3.": 0.03, "final_proj.weight": 6.0}

    def scale(name: str) -> float:
        return next((factor for part, factor in scales.items() if part in name), 1.0)

    return {n: (values * scale(n)).astype(np.float32) for n, values in weights.items()}


@dataclasses.dataclass(frozen=True)
class Affine:
    """y = weight x + bias."""

    weight: np.ndarray  # [out, in]
    bias: np.ndarray  # [out]

    def scaled(self, factor: float) -> "Affine":
        return Affine(self.weight * np.float32(factor), self.bias * np.float32(factor))


@dataclasses.dataclass(frozen=True)
class Layer:
    """An attentional layer; channels of a head lie together."""

    query: Affine
    key: Affine
    value: Affine
    merge: Affine
    mlp_a: Affine  # Of the token and the message side by side; a ReLU follows.
    mlp_b: Affine


@dataclasses.dataclass(frozen=True)
class SuperGlue:
    """Batch normalisation is folded into the map before it, as every engine's converter does;
    nothing else is."""

    encoder: list[Affine]  # A ReLU after each but the last.
    layers: list[Layer]
    final: Affine
    dustbin: np.float32

    @property
    def width(self) -> int:
        return len(self.final.bias)


def superglue(weights: Tensors) -> SuperGlue:
    def affine(name: str, norm: str = "") -> Affine:
        weight = weights[name + ".weight"].astype(np.float64)
        weight = weight.reshape(weight.shape[:2])
        bias = weights[name + ".bias"].astype(np.float64)
        if norm + ".weight" in weights:
            variance = weights[norm + ".running_var"].astype(np.float64)
            gain = weights[norm + ".weight"] / np.sqrt(variance + make_golden.BATCH_NORM_EPS)
            weight = gain[:, None] * weight
            bias = gain * (bias - weights[norm + ".running_mean"]) + weights[norm + ".bias"]
        return Affine(weight.astype(np.float32), bias.astype(np.float32))

    def layers() -> Iterator[Layer]:
        width = len(weights["final_proj.bias"])
        # Channel d * HEADS + head of the published form becomes head * (width / HEADS) + d.
        order = np.arange(width).reshape(-1, HEADS).T.reshape(-1)
        index = 0
        while f"gnn.layers.{index}.mlp.0.weight" in weights:
            prefix = f"gnn.layers.{index}."
            projections = [affine(f"{prefix}attn.proj.{i}") for i in range(3)]
            query, key, value = (Affine(p.weight[order], p.bias[order]) for p in projections)
            merge = affine(prefix + "attn.merge")
            yield Layer(
                query,
                key,
                value,
                Affine(merge.weight[:, order], merge.bias),
                affine(prefix + "mlp.0", prefix + "mlp.1"),
                affine(prefix + "mlp.3"),
            )
            index += 1

    encoder: list[Affine] = []
    while f"kenc.encoder.{3 * len(encoder)}.weight" in weights:
        module = 3 * len(encoder)
        encoder.append(affine(f"kenc.encoder.{module}", f"kenc.encoder.{module + 1}"))
    return SuperGlue(
        encoder, list(layers()), affine("final_proj"), np.float32(weights["bin_score"].item())
    )
