"""Both networks in ncnn's own format: a text of layers and the bytes of their weights.

Each image of SuperGlue goes through layers of its own. Products by `Gemm`, attention by
`MultiHeadAttention`; `InnerProduct` and `SDPA` in their place took the same time within 2 %
(ncnn 1.0.20261020).
"""

from collections.abc import Sequence

import numpy as np

from . import networks
from .networks import HEADS, Affine, Layer, SuperGlue, Tensors

MAGIC = "7767517"
POINTS = ("points0", "points1")
DESCRIPTORS = ("descriptors0", "descriptors1")


class Net:
    """A network in the making; blobs are named by strings."""

    def __init__(self) -> None:
        self._layers: list[tuple[str, list[str], str, str]] = []
        self._weights: list[bytes] = []

    def input(self, name: str) -> str:
        self._layers.append(("Input", [], name, ""))
        return name

    def add(self, kind: str, inputs: Sequence[str], **parameters: float) -> str:
        """`parameters` are ncnn's numbered ones: p8=65 is "8=65"."""
        output = f"blob{len(self._layers)}"
        text = " ".join(f"{name[1:]}={value}" for name, value in parameters.items())
        self._layers.append((kind, list(inputs), output, text))
        return output

    def add_weights(self, *tensors: np.ndarray) -> None:
        """Of the layer added last, with the mark for float32 before them."""
        for tensor in tensors:
            self._weights.append(b"\0\0\0\0")
            self.add_raw(tensor)

    def add_raw(self, tensor: np.ndarray) -> None:
        self._weights.append(np.ascontiguousarray(tensor, "<f4").tobytes())

    def parameters(self) -> str:
        """Every blob may be used once, so that `Split` layers copy those used more often."""
        uses: dict[str, int] = {}
        for _, inputs, _, _ in self._layers:
            for name in inputs:
                uses[name] = uses.get(name, 0) + 1
        lines: list[str] = []
        blobs = 0
        seen: dict[str, int] = {}

        def write(kind: str, inputs: list[str], outputs: list[str], text: str) -> None:
            nonlocal blobs
            blobs += len(outputs)
            words = [kind, f"layer{len(lines)}", str(len(inputs)), str(len(outputs))]
            lines.append(" ".join([*words, *inputs, *outputs, text]).rstrip())

        for kind, inputs, output, text in self._layers:
            names = []
            for name in inputs:
                index = seen.get(name, 0)
                seen[name] = index + 1
                names.append(f"{name}_{index}" if uses[name] > 1 else name)
            write(kind, names, [output], text)
            if uses.get(output, 0) > 1:
                write("Split", [output], [f"{output}_{i}" for i in range(uses[output])], "")
        return "\n".join([MAGIC, f"{len(lines)} {blobs}", *lines]) + "\n"

    def weights(self) -> bytes:
        return b"".join(self._weights)


def superpoint(weights: Tensors) -> tuple[Net, list[str]]:
    """Input "image", 0 to 1; returns the blobs of the logits and of the descriptors."""
    net = Net()

    def convolve(name: str, value: str, relu: bool = True) -> str:
        weight = weights[name + ".weight"]
        outputs, _, size, _ = weight.shape
        value = net.add(
            "Convolution",
            [value],
            p0=outputs,
            p1=size,
            p4=size // 2,
            p5=1,
            p6=weight.size,
            p9=int(relu),
        )
        net.add_weights(weight)
        net.add_raw(weights[name + ".bias"])
        return value

    value = net.input("image")
    for stage in networks.TRUNK:
        for name in (f"conv{stage}a", f"conv{stage}b"):
            value = convolve(name, value)
            if name in networks.POOLED:
                value = net.add("Pooling", [value], p0=0, p1=2, p2=2)
    logits = convolve("convPb", convolve("convPa", value), relu=False)
    descriptors = convolve("convDb", convolve("convDa", value), relu=False)
    return net, [logits, descriptors]


def superglue(network: SuperGlue) -> tuple[Net, list[str]]:
    """The graph network. Inputs POINTS (normalised x, y and score) and DESCRIPTORS, a row a
    keypoint; returns the blob of the scores."""
    net = Net()

    def affine(map_: Affine, value: str) -> str:
        outputs, inputs = map_.weight.shape
        value = net.add(
            "Gemm", [value], p2=0, p3=1, p4=0, p5=1, p6=1, p7=0, p8=outputs, p9=inputs, p10=4
        )
        net.add_weights(map_.weight, map_.bias)
        return value

    def encode(value: str) -> str:
        for map_ in network.encoder[:-1]:
            value = net.add("ReLU", [affine(map_, value)])
        return affine(network.encoder[-1], value)

    def propagate(layer: Layer, value: str, source: str) -> str:
        message = net.add(
            "MultiHeadAttention",
            [value, source, source],
            p0=network.width,
            p1=HEADS,
            p2=network.width**2,
        )
        for map_ in (layer.query, layer.key, layer.value, layer.merge):
            net.add_weights(map_.weight)
            net.add_raw(map_.bias)
        hidden = affine(layer.mlp_a, net.add("Concat", [value, message], p0=1))
        return net.add("BinaryOp", [value, affine(layer.mlp_b, net.add("ReLU", [hidden]))], p0=0)

    inputs = [(net.input(points), net.input(d)) for points, d in zip(POINTS, DESCRIPTORS)]
    tokens = [net.add("BinaryOp", [d, encode(points)], p0=0) for points, d in inputs]
    for index, layer in enumerate(network.layers):
        sources = tokens if index % 2 == 0 else tokens[::-1]
        tokens = [propagate(layer, *operands) for operands in zip(tokens, sources)]
    final = network.final.scaled(network.width**-0.25)
    return net, [net.add("Gemm", [affine(final, value) for value in tokens], p2=0, p3=1)]
