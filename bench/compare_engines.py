#!/usr/bin/env python3
"""Times gluevo's SuperPoint against ONNX Runtime on this machine, in one run, by turns.

    python3 -m venv build/engines && build/engines/bin/pip install numpy onnx onnxruntime
    build/engines/bin/python bench/compare_engines.py --weights superpoint.npz

gluevo's time is from image to keypoints and descriptors; ONNX Runtime's is the dense network alone
(semi-dense logits and descriptors), built here from the same weights.
"""
import argparse
import json
import os
import statistics
import subprocess
import time

import numpy as np
import onnx
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

TRUNK = ["conv1a", "conv1b", "conv2a", "conv2b", "conv3a", "conv3b", "conv4a", "conv4b"]


def build_model(weights, height, width):
    nodes, initializers = [], []

    def convolve(name, source, relu):
        kernel = weights[name + ".weight"]
        pad = kernel.shape[2] // 2
        for part in ("weight", "bias"):
            initializers.append(
                numpy_helper.from_array(weights[f"{name}.{part}"], f"{name}.{part}"))
        nodes.append(helper.make_node("Conv", [source, name + ".weight", name + ".bias"], [name],
                                      pads=[pad] * 4))
        if not relu:
            return name
        nodes.append(helper.make_node("Relu", [name], [name + ".relu"]))
        return name + ".relu"

    value = "image"
    for name in TRUNK:
        value = convolve(name, value, True)
        if name in ("conv1b", "conv2b", "conv3b"):
            nodes.append(helper.make_node("MaxPool", [value], [name + ".pool"],
                                          kernel_shape=[2, 2], strides=[2, 2]))
            value = name + ".pool"
    logits = convolve("convPb", convolve("convPa", value, True), False)
    descriptors = convolve("convDb", convolve("convDa", value, True), False)
    info = helper.make_tensor_value_info
    cells = [height // 8, width // 8]
    size = weights["convDb.weight"].shape[0]
    graph = helper.make_graph(
        nodes, "superpoint", [info("image", TensorProto.FLOAT, [1, 1, height, width])],
        [info(logits, TensorProto.FLOAT, [1, 65] + cells),
         info(descriptors, TensorProto.FLOAT, [1, size] + cells)],
        initializers)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)])
    model.ir_version = 8
    onnx.checker.check_model(model)
    return model.SerializeToString()


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--weights", required=True, help="SuperPoint .npz, published names")
    parser.add_argument("--gluevo", default="build/release/apps/gluevo")
    parser.add_argument("--size", default="752x480")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=15)
    arguments = parser.parse_args()
    width, height = map(int, arguments.size.split("x"))

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = arguments.threads
    session = onnxruntime.InferenceSession(
        build_model(np.load(arguments.weights), height, width), options,
        providers=["CPUExecutionProvider"])
    image = np.random.default_rng(1).random((1, 1, height, width), dtype=np.float32)
    session.run(None, {"image": image})

    ours, theirs = [], []
    for _ in range(arguments.rounds):
        output = subprocess.run(
            [arguments.gluevo, "bench", "--json", "--rounds", "1", "--size", arguments.size,
             "--threads", str(arguments.threads), "--superpoint", arguments.weights],
            check=True, capture_output=True, env=os.environ)
        ours.append(json.loads(output.stdout)["median_ms"])
        start = time.perf_counter()
        session.run(None, {"image": image})
        theirs.append((time.perf_counter() - start) * 1e3)
    ratios = [a / b for a, b in zip(ours, theirs)]
    print(f"SuperPoint {arguments.size}, {arguments.threads} threads, {arguments.rounds} rounds")
    print(f"median time, gluevo over ONNX Runtime {onnxruntime.__version__}: "
          f"{statistics.median(ratios):.2f} (least {min(ratios):.2f}, most {max(ratios):.2f})")


if __name__ == "__main__":
    main()
