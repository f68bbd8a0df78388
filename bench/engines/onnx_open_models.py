"""ALIKED's dense part and LightGlue as ONNX models of fixed size.

LightGlue has the forms of SuperGlue (onnx_models): in OpenVINO both images as one batch and
attention from plain operators, in ONNX Runtime the images apart and its own fused attention. A
pair of channels that positions turn is one channel of each half of a head: so both engines turn
whole halves.
"""

import numpy as np

from . import aliked as aliked_weights
from .aliked import Aliked, Convolution
from .lightglue import LAYER_NORM_EPS, Block, LightGlue
from .networks import Affine
from .onnx_models import Form, Graph

# Of the operator set: the first with deformable convolutions.
DEFORMABLE_OPSET = 19


def aliked(network: Aliked, height: int, width: int) -> bytes:
    """image [1, 1, height, width], 0 to 1 -> score_map [1, 1, height, width], feature_map
    [1, D, height, width]."""
    graph = Graph()
    top, bottom = aliked_weights.padding(height)
    left, right = aliked_weights.padding(width)

    def convolve(value: str, weight: np.ndarray, bias: np.ndarray | None = None) -> str:
        parameters = [graph.constant(weight)] + ([] if bias is None else [graph.constant(bias)])
        return graph.add("Conv", value, *parameters, pads=[weight.shape[2] // 2] * 4)

    def layer(value: str, convolution: Convolution, scale: int) -> str:
        map_ = convolution.map
        if convolution.offsets is None:
            return convolve(value, map_.weight, map_.bias)
        sides = ((top + height + bottom) // scale, (left + width + right) // scale)
        largest = aliked_weights.largest_offset(*sides)
        offsets = convolve(value, convolution.offsets.weight, convolution.offsets.bias)
        offsets = graph.add("Clip", offsets, graph.constant(-largest), graph.constant(largest))
        parameters = [graph.constant(map_.weight), offsets, graph.constant(map_.bias)]
        return graph.add("DeformConv", value, *parameters, pads=[1] * 4, kernel_shape=[3, 3])

    value = graph.input("image", [1, 1, height, width])
    pads = graph.constant([0, 0, top, left, 0, 0, bottom, right], np.int64)
    value = graph.add("Pad", value, pads, mode="edge")
    branches = []
    for block, pool, scale, branch in zip(
        network.blocks, aliked_weights.POOLS, aliked_weights.SCALES, network.branches
    ):
        if pool > 1:
            sides = [pool, pool]
            value = graph.add("AveragePool", value, kernel_shape=sides, strides=sides)
        whole = layer(graph.add("Selu", layer(value, block.first, scale)), block.second, scale)
        if block.shortcut is not None:
            shortcut = convolve(value, block.shortcut.weight, block.shortcut.bias)
            whole = graph.add("Add", whole, shortcut)
        value = graph.add("Selu", whole)
        seen = graph.add("Selu", convolve(value, branch))
        if scale > 1:
            scales = graph.constant([1, 1, scale, scale])
            mode = {"mode": "linear", "coordinate_transformation_mode": "align_corners"}
            seen = graph.add("Resize", seen, "", scales, **mode)
        branches.append(seen)
    features = graph.add("Concat", *branches, axis=1)
    scores = features
    for index, weight in enumerate(network.score_head):
        scores = convolve(scores, weight)
        scores = graph.add("Selu" if index < len(network.score_head) - 1 else "Sigmoid", scores)
    length = graph.add("ReduceL2", features, graph.constant([1], np.int64), keepdims=1)
    features = graph.add("Div", features, graph.add("Max", length, graph.constant(1e-12)))

    def crop(value: str) -> str:
        begin = graph.constant([top, left], np.int64)
        end = graph.constant([top + height, left + width], np.int64)
        return graph.add("Slice", value, begin, end, graph.constant([2, 3], np.int64))

    size = sum(len(branch) for branch in network.branches)
    outputs = {
        "score_map": (crop(scores), [1, 1, height, width]),
        "feature_map": (crop(features), [1, size, height, width]),
    }
    return graph.model(outputs, DEFORMABLE_OPSET)


def lightglue(network: LightGlue, count: int, form: Form) -> bytes:
    """All layers: points [2, count, 2] (normalised x and y), descriptors [2, count, D] -> the
    logarithm of the assignment [count, count], without those of having no match."""
    graph = Graph()
    width, heads = network.width, network.heads
    half = width // heads // 2
    images = 2 if form.batched else 1  # In a tensor.
    by_head = graph.constant([images, count, heads, 2 * half], np.int64)
    together = graph.constant([images, count, width], np.int64)
    # Channels 2 j and 2 j + 1 of a head become j and half + j.
    order = np.arange(width).reshape(heads, half, 2).transpose(0, 2, 1).reshape(-1)

    def affine(map_: Affine, value: str) -> str:
        product = graph.add("MatMul", value, graph.constant(map_.weight.T))
        return graph.add("Add", product, graph.constant(map_.bias))

    def split_heads(value: str, perm: list[int]) -> str:
        return graph.add("Transpose", graph.add("Reshape", value, by_head), perm=perm)

    def attend(query: str, key: str, value: str) -> str:
        """Of [images, heads, count, channels] where plain, else of [images, count, width]."""
        if form.fused_attention:
            attributes = {"domain": "com.microsoft", "num_heads": heads, "scale": 1.0}
            return graph.add("MultiHeadAttention", query, key, value, **attributes)
        turned = graph.add("Transpose", key, perm=[0, 1, 3, 2])
        shares = graph.add("Softmax", graph.add("MatMul", query, turned), axis=-1)
        message = graph.add("MatMul", shares, value)
        return graph.add("Reshape", graph.add("Transpose", message, perm=[0, 2, 1, 3]), together)

    def prepared(value: str) -> str:
        return value if form.fused_attention else split_heads(value, [0, 2, 1, 3])

    def turn(value: str, cosine: str, sine: str) -> str:
        parts = split_heads(value, [0, 2, 1, 3])
        first, second = graph.add_many("Split", 2, parts, axis=3, num_outputs=2)

        def product(a: str, b: str) -> str:
            return graph.add("Mul", a, b)

        left = graph.add("Sub", product(first, cosine), product(second, sine))
        right = graph.add("Add", product(second, cosine), product(first, sine))
        turned = graph.add("Concat", left, right, axis=3)
        if not form.fused_attention:
            return turned
        return graph.add("Reshape", graph.add("Transpose", turned, perm=[0, 2, 1, 3]), together)

    def gelu(value: str) -> str:
        error = graph.add("Erf", graph.add("Div", value, graph.constant(np.sqrt(2))))
        factor = graph.add("Add", error, graph.constant(1))
        return graph.add("Mul", graph.add("Mul", value, factor), graph.constant(0.5))

    def update(block: Block, token: str, message: str) -> str:
        ffn = block.ffn
        joined = graph.add("Concat", token, affine(block.out, message), axis=2)
        norm = [graph.constant(ffn.norm.weight), graph.constant(ffn.norm.bias)]
        hidden = graph.add(
            "LayerNormalization", affine(ffn.first, joined), *norm, epsilon=LAYER_NORM_EPS
        )
        return graph.add("Add", token, affine(ffn.second, gelu(hidden)))

    def within(block: Block, token: str, rotation: tuple[str, str]) -> str:
        query, key = block.query.scaled((2 * half) ** -0.5), block.key
        query, key = (Affine(m.weight[order], m.bias[order]) for m in (query, key))
        turned = [turn(affine(map_, token), *rotation) for map_ in (query, key)]
        return update(block, token, attend(*turned, prepared(affine(block.value, token))))

    def across(block: Block, tokens: list[str]) -> list[str]:
        both = block.query.scaled((2 * half) ** -0.25)
        queries = [prepared(affine(both, token)) for token in tokens]
        values = [prepared(affine(block.value, token)) for token in tokens]
        if form.batched:
            swapped = graph.constant([1, 0], np.int64)
            keys, values = (
                [graph.add("Gather", x[0], swapped, axis=0)] for x in (queries, values)
            )
        else:
            keys, values = queries[::-1], values[::-1]
        messages = map(attend, queries, keys, values)
        return [update(block, token, message) for token, message in zip(tokens, messages)]

    def halves(value: str) -> list[str]:
        return [value] if form.batched else graph.add_many("Split", 2, value, axis=0, num_outputs=2)

    def rotation(points: str) -> tuple[str, str]:
        angles = graph.add("MatMul", points, graph.constant(network.frequencies.T))
        one_head = graph.constant([images, 1, count, half], np.int64)
        angles = graph.add("Reshape", angles, one_head)
        return graph.add("Cos", angles), graph.add("Sin", angles)

    rotations = [rotation(value) for value in halves(graph.input("points", [2, count, 2]))]
    descriptors = graph.input("descriptors", [2, count, network.descriptor_size])
    tokens = [affine(network.input, value) for value in halves(descriptors)]
    for self_block, cross_block in network.layers:
        tokens = [within(self_block, *pair) for pair in zip(tokens, rotations)]
        tokens = across(cross_block, tokens)
    return graph.model({"log_assignment": (_assign(graph, network, tokens), [count, count])})


def _assign(graph: Graph, network: LightGlue, tokens: list[str]) -> str:
    def affine(map_: Affine, value: str) -> str:
        product = graph.add("MatMul", value, graph.constant(map_.weight.T))
        return graph.add("Add", product, graph.constant(map_.bias))

    def both(values: list[str]) -> list[str]:
        """Of each image, without its axis."""
        axis = graph.constant([0], np.int64)
        if len(values) == 1:
            values = graph.add_many("Split", 2, values[0], axis=0, num_outputs=2)
        return [graph.add("Squeeze", value, axis) for value in values]

    final = network.final.scaled(network.width**-0.25)
    first, second = both([affine(final, token) for token in tokens])
    scores = graph.add("MatMul", first, graph.add("Transpose", second, perm=[1, 0]))
    seen = [affine(network.matchability, token) for token in tokens]
    # log sigmoid(z) = -softplus(-z).
    unseen = [graph.add("Softplus", graph.add("Neg", value)) for value in seen]
    rows, columns = both(unseen)
    softmax = [graph.add("LogSoftmax", scores, axis=axis) for axis in (1, 0)]
    result = graph.add("Sub", graph.add("Add", *softmax), rows)
    return graph.add("Sub", result, graph.add("Transpose", columns, perm=[1, 0]))
