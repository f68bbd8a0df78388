"""SuperPoint, SuperGlue and Sinkhorn's algorithm as ONNX models of fixed size.

The forms are the fastest of those tried in ONNX Runtime 1.32 and OpenVINO 2026.4: tokens as rows,
each layer's three projections apart; in OpenVINO both images as one batch and attention from plain
operators, in ONNX Runtime the images apart and its own fused attention.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from . import networks
from .networks import HEADS, Affine, Layer, SuperGlue, Tensors

# Of the operator set: since 18 all reductions take their axes as an input.
OPSET = 18


class Graph:
    """A model in the making; values are named by strings."""

    def __init__(self) -> None:
        self._nodes: list[onnx.NodeProto] = []
        self._constants: list[onnx.TensorProto] = []
        self._inputs: list[onnx.ValueInfoProto] = []

    def input(self, name: str, shape: Sequence[int]) -> str:
        self._inputs.append(helper.make_tensor_value_info(name, TensorProto.FLOAT, shape))
        return name

    def constant(self, values: Any, dtype: type = np.float32) -> str:
        name = f"constant{len(self._constants)}"
        array: np.ndarray = np.ascontiguousarray(np.asarray(values, dtype))
        self._constants.append(numpy_helper.from_array(array, name))
        return name

    def add(self, operator: str, *inputs: str, domain: str = "", **attributes: Any) -> str:
        return self.add_many(operator, 1, *inputs, domain=domain, **attributes)[0]

    def add_many(
        self, operator: str, outputs: int, *inputs: str, domain: str = "", **attributes: Any
    ) -> list[str]:
        names = [f"value{len(self._nodes)}_{i}" for i in range(outputs)]
        self._nodes.append(helper.make_node(operator, inputs, names, domain=domain, **attributes))
        return names

    def model(self, outputs: dict[str, tuple[str, Sequence[int]]], opset: int = OPSET) -> bytes:
        """`outputs`: of each name the value and its shape."""
        for name, (value, _) in outputs.items():
            self._nodes.append(helper.make_node("Identity", [value], [name]))
        results = [
            helper.make_tensor_value_info(name, TensorProto.FLOAT, shape)
            for name, (_, shape) in outputs.items()
        ]
        graph = helper.make_graph(self._nodes, "graph", self._inputs, results, self._constants)
        opsets = [helper.make_opsetid("", opset), helper.make_opsetid("com.microsoft", 1)]
        model = helper.make_model(graph, opset_imports=opsets)
        model.ir_version = 10
        onnx.checker.check_model(model)
        return model.SerializeToString()


def superpoint(weights: Tensors, height: int, width: int) -> bytes:
    """image [1, 1, height, width], 0 to 1 -> logits [1, 65, h, w], descriptors [1, D, h, w]."""
    graph = Graph()

    def convolve(name: str, value: str, relu: bool = True) -> str:
        weight = weights[name + ".weight"]
        pads = [weight.shape[2] // 2] * 4
        parameters = [graph.constant(weight), graph.constant(weights[name + ".bias"])]
        value = graph.add("Conv", value, *parameters, pads=pads)
        return graph.add("Relu", value) if relu else value

    value = graph.input("image", [1, 1, height, width])
    for stage in networks.TRUNK:
        for name in (f"conv{stage}a", f"conv{stage}b"):
            value = convolve(name, value)
            if name in networks.POOLED:
                value = graph.add("MaxPool", value, kernel_shape=[2, 2], strides=[2, 2])
    cells = [height // 8, width // 8]
    size = len(weights["convDb.bias"])
    return graph.model(
        {
            "logits": (convolve("convPb", convolve("convPa", value), False), [1, 65, *cells]),
            "descriptors": (
                convolve("convDb", convolve("convDa", value), False),
                [1, size, *cells],
            ),
        }
    )


@dataclasses.dataclass(frozen=True)
class Form:
    batched: bool  # Both images in one tensor.
    fused_attention: bool  # By ONNX Runtime's own operator.


def superglue(network: SuperGlue, count: int, form: Form) -> bytes:
    """The graph network: points [2, count, 3] (normalised x, y and score), descriptors
    [2, count, D] -> scores [count, count]."""
    graph = Graph()
    width = network.width
    images = 2 if form.batched else 1  # In a tensor.

    def affine(map_: Affine, value: str) -> str:
        product = graph.add("MatMul", value, graph.constant(map_.weight.T))
        return graph.add("Add", product, graph.constant(map_.bias))

    def encode(value: str) -> str:
        for map_ in network.encoder[:-1]:
            value = graph.add("Relu", affine(map_, value))
        return affine(network.encoder[-1], value)

    by_head = graph.constant([images, count, HEADS, width // HEADS], np.int64)
    together = graph.constant([images, count, width], np.int64)

    def heads(value: str, order: list[int]) -> str:
        return graph.add("Transpose", graph.add("Reshape", value, by_head), perm=order)

    def attend(query: str, key: str, value: str) -> str:
        if form.fused_attention:
            return graph.add(
                "MultiHeadAttention",
                query,
                key,
                value,
                domain="com.microsoft",
                num_heads=HEADS,
                scale=1.0,
            )
        scores = graph.add("MatMul", heads(query, [0, 2, 1, 3]), heads(key, [0, 2, 3, 1]))
        shares = graph.add("Softmax", scores, axis=-1)
        message = graph.add("MatMul", shares, heads(value, [0, 2, 1, 3]))
        return graph.add("Reshape", graph.add("Transpose", message, perm=[0, 2, 1, 3]), together)

    def split(value: str) -> list[str]:
        return graph.add_many("Split", 2, value, axis=0, num_outputs=2)

    def propagate(layer: Layer, value: str, key: str, weighted: str) -> str:
        query = layer.query.scaled((width // HEADS) ** -0.5)
        message = affine(layer.merge, attend(affine(query, value), key, weighted))
        hidden = affine(layer.mlp_a, graph.add("Concat", value, message, axis=2))
        return graph.add("Add", value, affine(layer.mlp_b, graph.add("Relu", hidden)))

    points = graph.input("points", [2, count, 3])
    descriptors = graph.input("descriptors", [2, count, width])
    if form.batched:
        tokens = [graph.add("Add", descriptors, encode(points))]
    else:
        both = zip(split(points), split(descriptors))
        tokens = [graph.add("Add", values, encode(at)) for at, values in both]
    swapped = graph.constant([1, 0], np.int64)
    for index, layer in enumerate(network.layers):
        keys = [affine(layer.key, value) for value in tokens]
        values = [affine(layer.value, value) for value in tokens]
        if index % 2 == 1:
            if form.batched:
                keys, values = (
                    [graph.add("Gather", x[0], swapped, axis=0)] for x in (keys, values)
                )
            else:
                keys, values = keys[::-1], values[::-1]
        tokens = [propagate(layer, *operands) for operands in zip(tokens, keys, values)]

    final = network.final.scaled(width**-0.25)
    projected = [affine(final, value) for value in tokens]
    first, second = split(projected[0]) if form.batched else projected
    scores = graph.add("MatMul", first, graph.add("Transpose", second, perm=[0, 2, 1]))
    scores = graph.add("Reshape", scores, graph.constant([count, count], np.int64))
    return graph.model({"scores": (scores, [count, count])})


def sinkhorn(count: int, dustbin: np.float32) -> bytes:
    """scores [count, count] -> log assignment [count + 1, count + 1].

    In the log domain with one exponential an entry and iteration, in place of the two of the
    published form, which took ONNX Runtime 105 ms in place of 15 at 500 keypoints: with
    e = exp(z + v - m), m the rows' maxima and s the rows' sums of e, u = log mu - m - log s, and v
    falls by the logarithm of the columns' sums of e mu / s over nu.
    """
    graph = Graph()
    log_mass = np.zeros(count + 1)
    log_mass[-1] = np.log(count)
    log_mass -= np.log(2 * count)
    mu = graph.constant(np.exp(log_mass)[:, None])
    log_mu = graph.constant(log_mass[:, None])
    log_nu = graph.constant(log_mass[None, :])
    columns = graph.constant([1], np.int64)

    scores = graph.input("scores", [count, count])
    column = graph.constant(np.full((count, 1), dustbin))
    row = graph.constant(np.full((1, count + 1), dustbin))
    z = graph.add("Concat", graph.add("Concat", scores, column, axis=1), row, axis=0)
    u = ""
    v = graph.constant(np.zeros((1, count + 1)))
    for _ in range(networks.SINKHORN_ITERATIONS):
        lifted = graph.add("Add", z, v)
        most = graph.add("ReduceMax", lifted, columns, keepdims=1)
        e = graph.add("Exp", graph.add("Sub", lifted, most))
        row_sums = graph.add("ReduceSum", e, columns, keepdims=1)
        shares = graph.add("Transpose", graph.add("Div", mu, row_sums), perm=[1, 0])
        column_sums = graph.add("MatMul", shares, e)
        u = graph.add("Sub", graph.add("Sub", log_mu, most), graph.add("Log", row_sums))
        v = graph.add("Sub", graph.add("Add", v, log_nu), graph.add("Log", column_sums))
    norm = graph.constant(np.log(2 * count))
    assignment = graph.add("Add", graph.add("Add", graph.add("Add", z, u), v), norm)
    return graph.model({"log_assignment": (assignment, [count + 1, count + 1])})
