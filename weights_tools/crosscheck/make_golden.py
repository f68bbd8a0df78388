#!/usr/bin/env python3
"""Small random networks in each dialect and container, with their outputs by torch in double
precision, for the tests (tests/data/weights).

    python3 weights_tools/crosscheck/make_golden.py [--out tests/data/weights]
"""

import argparse
import copy
import os

import inputs
import networks
import onnx
import superglues
import superpoints
import torch
from safetensors.torch import save_file

WIDTHS = dict(widths=(8, 8, 12, 12), head=16, size=32)
GLUE = dict(size=32, encoder=(8, 16), layers=2, heads=4)


def superpoint_outputs(network, pixels, run=None):
    x = torch.tensor(pixels, dtype=torch.float64)[None, None] / 255
    double = copy.deepcopy(network).double().eval()
    with torch.no_grad():
        return superpoints.dense_maps(*(run(double, x) if run else double(x)))


class WithAssignment(torch.nn.Module):
    """A SuperGlue to its assignment, as whoever exports one would have it."""

    def __init__(self, network, scores):
        super().__init__()
        self.net = network
        self.scores = scores

    def forward(self, *features):
        scores = self.scores(self.net, *features)
        return superglues.log_assignment(scores, self.net.bin_score, iterations=2)


def export(network, arguments, path, dynamo=False, keypoints=False):
    """With sizes that may vary, as exporters ask for: keypoints along the first axes."""
    options = {"external_data": False} if dynamo else {}
    if int(torch.__version__.split(".")[0]) >= 2:  # torch 1 has one exporter, and no name for it.
        options["dynamo"] = dynamo
    if keypoints and dynamo:
        count = torch.export.Dim("count", min=2, max=4096)
        options["dynamic_shapes"] = [tuple({0: count} for _ in arguments)]
    elif keypoints:
        names = [f"input{i}" for i in range(len(arguments))]
        options["input_names"] = names
        options["dynamic_axes"] = {name: {0: "count"} for name in names}
    torch.onnx.export(network, tuple(arguments), path, **options)
    model = onnx.load(path)
    for node in model.graph.node:
        del node.metadata_props[:]  # Stack traces of the machine that it was made on.
    onnx.save(model, path)


def make_int8(network, pixels, path, operators=False):
    """Quantises an export to int8 with a scale a channel, between QuantizeLinear and
    DequantizeLinear or into QLinearConv; returns the network with the values that the file holds."""
    from onnxruntime.quantization import CalibrationDataReader, QuantFormat, quantize_static

    class Images(CalibrationDataReader):
        def __init__(self):
            self.left = [{"image": (pixels[None, None] / 255).astype("float32")}]

        def get_next(self):
            return self.left.pop() if self.left else None

    plain = path + ".float"
    example = torch.zeros(1, 1, *pixels.shape)
    torch.onnx.export(network, (example,), plain, dynamo=False, input_names=["image"])
    form = QuantFormat.QOperator if operators else QuantFormat.QDQ
    quantize_static(plain, path, Images(), quant_format=form, per_channel=True)
    os.remove(plain)
    changed = copy.deepcopy(network).double()
    changed.load_state_dict((values_of_operators if operators else values_between)(network, path))
    return changed


def dequantized(numbers, scale):
    scale = scale.astype("float64").reshape(-1, *([1] * (numbers.ndim - 1)))
    return torch.tensor(numbers.astype("float64") * scale)


def initializers(model):
    return {t.name: onnx.numpy_helper.to_array(t) for t in model.graph.initializer}


def values_between(network, path):
    tensors = initializers(onnx.load(path))
    scale = lambda name: tensors[name + ("_scale" if name + "_scale" in tensors else "_quantized_scale")]
    names = network.state_dict()
    return {name: dequantized(tensors[name + "_quantized"], scale(name)) for name in names}


def values_of_operators(network, path):
    model = onnx.load(path)
    tensors = initializers(model)
    state = {}
    for node in model.graph.node:
        if node.op_type == "QLinearConv":
            x_scale, weight, scale, zero, bias = (node.input[i] for i in (1, 3, 4, 5, 8))
            assert not tensors[zero].any()
            scale = tensors[scale].astype("float64")
            state[weight.removesuffix("_quantized")] = dequantized(tensors[weight], scale)
            bias_scale = scale * tensors[x_scale].astype("float64")
            state[bias.removesuffix("_quantized")] = dequantized(tensors[bias], bias_scale)
    assert set(state) == set(network.state_dict()), sorted(state)
    return state


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="tests/data/weights")
    out = parser.parse_args().out
    path = lambda name: os.path.join(out, name)
    pixels = inputs.image(48, 56)

    def golden(name, network, run=None):
        outputs = superpoint_outputs(network, pixels, run)
        inputs.save_superpoint_golden(path(f"golden_{name}.safetensors"), pixels, *outputs)

    network = networks.randomize(superpoints.MagicLeapSuperPoint(**WIDTHS), 1)
    golden("superpoint_magic_leap", network)
    torch.save(network.state_dict(), path("superpoint_magic_leap.pth"))

    network = networks.randomize(superpoints.RpautratSuperPoint(**WIDTHS), 2)
    golden("superpoint_rpautrat", network)
    torch.save(
        network.state_dict(),
        path("superpoint_rpautrat.pth"),
        _use_new_zipfile_serialization=False,
    )

    image = torch.zeros(1, 1, *pixels.shape)
    export(network, [image], path("superpoint_rpautrat.onnx"))

    network = networks.randomize(superpoints.MagicLeapSuperPoint(**WIDTHS), 6)
    golden("superpoint_int8", make_int8(network, pixels, path("superpoint_int8.onnx")))
    quantized = make_int8(network, pixels, path("superpoint_qlinear.onnx"), operators=True)
    golden("superpoint_qlinear", quantized)

    network = networks.randomize(superpoints.PytorchSuperpoint(**WIDTHS), 3)
    export(network, [image], path("superpoint_folded.onnx"))
    export(network, [image], path("superpoint_folded_dynamo.onnx"), dynamo=True)
    golden("superpoint_batch_norm", network)
    checkpoint = {"n_iter": 7, "model_state_dict": network.state_dict(), "loss": torch.ones(1)}
    torch.save(checkpoint, path("superpoint_batch_norm.pth.tar"))

    network = networks.randomize(superpoints.hugging_face_superpoint(**WIDTHS), 4)
    golden("superpoint_hugging_face", network, superpoints.hugging_face_superpoint_outputs)
    save_file(network.state_dict(), path("superpoint_hugging_face.safetensors"))

    # Both networks in one file, and its SuperGlue under the published names.
    network = networks.randomize(superglues.hugging_face_superglue(**GLUE, **{
        "widths": WIDTHS["widths"], "head": WIDTHS["head"]}), 5)
    networks.sharpen(network)
    save_file(network.state_dict(), path("both_hugging_face.safetensors"))
    published = superglues.magic_leap_names(network)
    torch.save(
        {"module.net." + name: value for name, value in published.items()},
        path("superglue_magic_leap.pth"),
        _use_new_zipfile_serialization=False,
    )
    width, height = 320, 240
    first, second = inputs.features(24, GLUE["size"], width, height)
    double = copy.deepcopy(network).double().eval()
    arguments = []
    for keypoints, scores, descriptors in (first, second):
        keypoints = superglues.normalized_keypoints(keypoints.double(), width, height)
        arguments += [keypoints, scores.double(), descriptors.double()]
    with torch.no_grad():
        scores = superglues.hugging_face_scores(double, *arguments)
        assignment = superglues.log_assignment(scores, double.bin_score)
        own = superglues.MagicLeapSuperGlue(**GLUE).double().eval()
        own.load_state_dict({name: value.double() for name, value in published.items()})
        difference = (own(*arguments) - scores).abs().max()
    assert difference < 1e-9, f"the two SuperGlues differ by {difference}"
    small = [argument.float() for argument in arguments]
    export(WithAssignment(network, superglues.hugging_face_scores), small,
           path("superglue_hugging_face.onnx"), keypoints=True)
    scores_of = lambda net, *features: net(*features)
    export(WithAssignment(own.float(), scores_of), small, path("superglue_folded.onnx"), keypoints=True)
    export(WithAssignment(own, scores_of), small, path("superglue_dynamo.onnx"), dynamo=True, keypoints=True)
    matched = int((assignment[:-1, :-1].exp() > 0.2).sum())
    assert matched > 12, f"only {matched} matches"
    inputs.save_superglue_golden(
        path("golden_superglue.safetensors"), width, height, first, second, assignment
    )


if __name__ == "__main__":
    main()
