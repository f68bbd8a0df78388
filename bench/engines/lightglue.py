"""LightGlue's weights as plain matrices (Lindenberger et al. 2023), as every engine takes them."""

import dataclasses

import numpy as np

from .networks import Affine, Tensors

DEPTH = 9
WIDTH = 256
HEADS = 4
LAYER_NORM_EPS = 1e-5


@dataclasses.dataclass(frozen=True)
class Ffn:
    """Of the token and the message side by side: a map, layer normalisation, GELU, a map."""

    first: Affine
    norm: Affine  # Gain and offset of each channel.
    second: Affine


@dataclasses.dataclass(frozen=True)
class Block:
    """Projections are [token channels] -> [heads x channels of a head], heads one after the other."""

    query: Affine
    key: Affine  # A cross block's is its query, too.
    value: Affine
    out: Affine
    ffn: Ffn


@dataclasses.dataclass(frozen=True)
class LightGlue:
    input: Affine
    frequencies: np.ndarray  # [half a head's channels, 2]: of the position that turns a pair.
    layers: list[tuple[Block, Block]]  # Within an image, then across both.
    final: Affine
    matchability: Affine
    heads: int

    @property
    def width(self) -> int:
        return len(self.final.bias)

    @property
    def descriptor_size(self) -> int:
        return self.input.weight.shape[1]


def lightglue(weights: Tensors, heads: int = HEADS) -> LightGlue:
    """The assignment is that of the last layer, as without early stopping."""

    def affine(name: str) -> Affine:
        return Affine(weights[name + ".weight"], weights[name + ".bias"])

    def ffn(prefix: str) -> Ffn:
        return Ffn(affine(prefix + "0"), affine(prefix + "1"), affine(prefix + "3"))

    def within(prefix: str) -> Block:
        packed = affine(prefix + "Wqkv")
        # Row 3 (channel) + 0, 1, 2 of a head holds query, key and value.
        query, key, value = (Affine(packed.weight[i::3], packed.bias[i::3]) for i in range(3))
        return Block(query, key, value, affine(prefix + "out_proj"), ffn(prefix + "ffn."))

    def across(prefix: str) -> Block:
        both = affine(prefix + "to_qk")
        value, out = affine(prefix + "to_v"), affine(prefix + "to_out")
        return Block(both, both, value, out, ffn(prefix + "ffn."))

    layers = []
    while f"transformers.{len(layers)}.self_attn.Wqkv.weight" in weights:
        prefix = f"transformers.{len(layers)}."
        layers.append((within(prefix + "self_attn."), across(prefix + "cross_attn.")))
    assignment = f"log_assignment.{len(layers) - 1}."
    return LightGlue(
        affine("input_proj"),
        weights["posenc.Wr.weight"],
        layers,
        affine(assignment + "final_proj"),
        affine(assignment + "matchability"),
        heads,
    )


def random_lightglue(seed: int, descriptor_size: int = 128) -> Tensors:
    """Of the shape published for ALIKED."""
    rng = np.random.default_rng(seed)
    weights: dict[str, np.ndarray] = {}

    def add(name: str, outputs: int, inputs: int, gain: float = 1.0) -> None:
        weight = rng.standard_normal((outputs, inputs)) * gain / np.sqrt(inputs)
        weights[name + ".weight"] = weight.astype(np.float32)
        weights[name + ".bias"] = (rng.standard_normal(outputs) * 0.01).astype(np.float32)

    add("input_proj", WIDTH, descriptor_size)
    weights["posenc.Wr.weight"] = rng.standard_normal((WIDTH // HEADS // 2, 2)).astype(np.float32)
    for index in range(DEPTH):
        prefix = f"transformers.{index}."
        add(prefix + "self_attn.Wqkv", 3 * WIDTH, WIDTH)
        add(prefix + "self_attn.out_proj", WIDTH, WIDTH)
        add(prefix + "cross_attn.to_qk", WIDTH, WIDTH)
        add(prefix + "cross_attn.to_v", WIDTH, WIDTH)
        add(prefix + "cross_attn.to_out", WIDTH, WIDTH)
        for kind in ("self", "cross"):
            ffn = f"{prefix}{kind}_attn.ffn."
            add(ffn + "0", 2 * WIDTH, 2 * WIDTH)
            weights[ffn + "1.weight"] = np.ones(2 * WIDTH, np.float32)
            weights[ffn + "1.bias"] = np.zeros(2 * WIDTH, np.float32)
            # Small, so that nine layers leave the tokens of the size that they had.
            add(ffn + "3", WIDTH, 2 * WIDTH, 0.3)
        add(f"log_assignment.{index}.final_proj", WIDTH, WIDTH, 2.0)
        add(f"log_assignment.{index}.matchability", 1, WIDTH)
        if index < DEPTH - 1:
            add(f"token_confidence.{index}.token.0", 1, WIDTH)
    return weights
