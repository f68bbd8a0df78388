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
import torch
from safetensors.torch import save_file

WIDTHS = dict(widths=(8, 8, 12, 12), head=16, size=32)
GLUE = dict(size=32, encoder=(8, 16), layers=2, heads=4)


def superpoint_outputs(network, pixels, run=None):
    x = torch.tensor(pixels, dtype=torch.float64)[None, None] / 255
    double = copy.deepcopy(network).double().eval()
    with torch.no_grad():
        return networks.dense_maps(*(run(double, x) if run else double(x)))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="tests/data/weights")
    out = parser.parse_args().out
    path = lambda name: os.path.join(out, name)
    pixels = inputs.image(48, 56)

    def golden(name, network, run=None):
        outputs = superpoint_outputs(network, pixels, run)
        inputs.save_superpoint_golden(path(f"golden_{name}.safetensors"), pixels, *outputs)

    network = networks.randomize(networks.MagicLeapSuperPoint(**WIDTHS), 1)
    golden("superpoint_magic_leap", network)
    torch.save(network.state_dict(), path("superpoint_magic_leap.pth"))

    network = networks.randomize(networks.RpautratSuperPoint(**WIDTHS), 2)
    golden("superpoint_rpautrat", network)
    torch.save(
        network.state_dict(),
        path("superpoint_rpautrat.pth"),
        _use_new_zipfile_serialization=False,
    )

    network = networks.randomize(networks.PytorchSuperpoint(**WIDTHS), 3)
    golden("superpoint_batch_norm", network)
    checkpoint = {"n_iter": 7, "model_state_dict": network.state_dict(), "loss": torch.ones(1)}
    torch.save(checkpoint, path("superpoint_batch_norm.pth.tar"))

    network = networks.randomize(networks.hugging_face_superpoint(**WIDTHS), 4)
    golden("superpoint_hugging_face", network, networks.hugging_face_superpoint_outputs)
    save_file(network.state_dict(), path("superpoint_hugging_face.safetensors"))

    # Both networks in one file, and its SuperGlue under the published names.
    network = networks.randomize(networks.hugging_face_superglue(**GLUE, **{
        "widths": WIDTHS["widths"], "head": WIDTHS["head"]}), 5)
    networks.sharpen(network.final_projection.final_proj)
    save_file(network.state_dict(), path("both_hugging_face.safetensors"))
    published = networks.magic_leap_names(network)
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
        keypoints = networks.normalized_keypoints(keypoints.double(), width, height)
        arguments += [keypoints, scores.double(), descriptors.double()]
    with torch.no_grad():
        scores = networks.hugging_face_scores(double, *arguments)
        assignment = networks.log_assignment(scores, double.bin_score)
        own = networks.MagicLeapSuperGlue(**GLUE).double().eval()
        own.load_state_dict({name: value.double() for name, value in published.items()})
        difference = (own(*arguments) - scores).abs().max()
    assert difference < 1e-9, f"the two SuperGlues differ by {difference}"
    matched = int((assignment[:-1, :-1].exp() > 0.2).sum())
    assert matched > 12, f"only {matched} matches"
    inputs.save_superglue_golden(
        path("golden_superglue.safetensors"), width, height, first, second, assignment
    )


if __name__ == "__main__":
    main()
