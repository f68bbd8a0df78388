"""ALIKED's weights as plain arrays (Zhao et al. 2023), as every engine takes them."""

import dataclasses

import numpy as np

from .networks import Affine, Tensors, make_golden

DIVISOR = 32  # Images are padded to multiples of it, the border repeated.
N16 = (16, 32, 64, 128)
SAMPLES = 16  # Of a descriptor.


@dataclasses.dataclass(frozen=True)
class Convolution:
    """3 x 3, batch normalisation folded in; deformable where there are offsets: for each of the
    nine taps dy and dx."""

    map: Affine  # Its weight is [out, in, 3, 3].
    offsets: Affine | None = None


@dataclasses.dataclass(frozen=True)
class Block:
    first: Convolution
    second: Convolution
    shortcut: Affine | None  # [out, in, 1, 1]


@dataclasses.dataclass(frozen=True)
class Aliked:
    """The dense part. Gray images: the first layer's three channels are summed."""

    blocks: list[Block]
    branches: list[np.ndarray]  # [D / 4, in, 1, 1], without bias.
    score_head: list[np.ndarray]  # Without bias.


# By how much each block's input is smaller than the one's before.
POOLS = (1, 2, 4, 4)
SCALES = tuple(int(np.prod(POOLS[: i + 1])) for i in range(4))


def aliked(weights: Tensors) -> Aliked:
    def convolution(name: str, norm: str) -> Convolution:
        offsets = None
        if name + ".offset_conv.weight" in weights:
            offsets = Affine(weights[name + ".offset_conv.weight"], weights[name + ".offset_conv.bias"])
            name += ".regular_conv"
        variance = weights[norm + ".running_var"].astype(np.float64)
        gain = weights[norm + ".weight"] / np.sqrt(variance + make_golden.BATCH_NORM_EPS)
        weight = gain[:, None, None, None] * weights[name + ".weight"].astype(np.float64)
        bias = weights[norm + ".bias"] - gain * weights[norm + ".running_mean"]
        if weight.shape[1] == 3:
            weight = weight.sum(axis=1, keepdims=True)
        return Convolution(Affine(weight.astype(np.float32), bias.astype(np.float32)), offsets)

    blocks = []
    for index in range(1, 5):
        prefix = f"block{index}."
        shortcut = None
        if prefix + "downsample.weight" in weights:
            shortcut = Affine(weights[prefix + "downsample.weight"], weights[prefix + "downsample.bias"])
        parts = [convolution(f"{prefix}conv{i}", f"{prefix}bn{i}") for i in (1, 2)]
        blocks.append(Block(*parts, shortcut))
    return Aliked(
        blocks,
        [weights[f"conv{index}.weight"] for index in range(1, 5)],
        [weights[f"score_head.{index}.weight"] for index in (0, 2, 4, 6)],
    )


def padding(size: int) -> tuple[int, int]:
    """Before and after."""
    missing = -size % DIVISOR
    return missing // 2, missing - missing // 2


def largest_offset(height: int, width: int) -> float:
    """Of deformable samples on a map, pixels of it."""
    return max(height, width) / 4


def random_aliked(
    seed: int, widths: tuple[int, ...] = N16, size: int = 128, samples: int = SAMPLES
) -> Tensors:
    """Of the published shape; activations keep their size from layer to layer (He et al. 2015)."""
    rng = np.random.default_rng(seed)
    weights: dict[str, np.ndarray] = {}

    def add(name: str, shape: tuple[int, ...], gain: float = 1.0, has_bias: bool = False) -> None:
        scale = gain / np.sqrt(np.prod(shape[1:]))
        weights[name + ".weight"] = (rng.standard_normal(shape) * scale).astype(np.float32)
        if has_bias:
            weights[name + ".bias"] = (rng.standard_normal(shape[0]) * 0.05).astype(np.float32)

    def norm(name: str, channels: int) -> None:
        for part, value in (("weight", 1), ("bias", 0), ("running_mean", 0), ("running_var", 1)):
            weights[f"{name}.{part}"] = np.full(channels, value, np.float32)

    inputs = 3
    for index, outputs in enumerate(widths, 1):
        for part, channels in ((1, inputs), (2, outputs)):
            name = f"block{index}.conv{part}"
            if index > 2:
                # Of some pixels.
                add(name + ".offset_conv", (18, channels, 3, 3), 2.0, has_bias=True)
                name += ".regular_conv"
            add(name, (outputs, channels, 3, 3))
            norm(f"block{index}.bn{part}", outputs)
        if index > 1:
            add(f"block{index}.downsample", (outputs, inputs, 1, 1), has_bias=True)
        add(f"conv{index}", (size // 4, outputs, 1, 1))
        inputs = outputs
    for index, outputs, channels in ((0, 8, size), (2, 4, 8), (4, 4, 4), (6, 1, 4)):
        side = 1 if index == 0 else 3
        add(f"score_head.{index}", (outputs, channels, side, side), 2.0)
    add("desc_head.offset_conv.0", (2 * samples, size, 3, 3), has_bias=True)
    add("desc_head.offset_conv.2", (2 * samples, 2 * samples, 1, 1), 4.0, has_bias=True)
    add("desc_head.sf_conv", (size, size, 1, 1))
    agg = rng.standard_normal((samples, size, size)) / np.sqrt(samples * size)
    weights["desc_head.agg_weights"] = agg.astype(np.float32)
    return weights
