#!/usr/bin/env python3
"""Random networks of the published sizes in each dialect and container: gluevo must give what torch
and transformers give.

    python3 weights_tools/crosscheck/crosscheck.py --run-network PROGRAM [--small]

PROGRAM is built from run_network.cc beside this file (target weights_tools_run_network). Needs
torch, transformers and safetensors; where they are missing it exits with 77, which ctest takes for
skipped.
"""

import argparse
import os
import subprocess
import sys
import tempfile

try:
    import inputs
    import networks
    import torch
    import transformers  # noqa: F401
    from safetensors.torch import load_file, save_file
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)

TOLERANCE = 1e-4  # Of scores absolutely, of descriptors and dense maps by relative RMS.
failures = []


def check(what, value, allowed):
    verdict = "ok" if value <= allowed else "TOO FAR"
    print(f"  {what:52s} {value:9.2e} of {allowed:.0e}  {verdict}")
    if not value <= allowed:
        failures.append(what)


def relative_rms(actual, expected):
    return float((actual.double() - expected.double()).norm() / expected.double().norm())


def run(program, folder, weights, tensors):
    source, target = os.path.join(folder, "input"), os.path.join(folder, "output")
    save_file({name: value.float().contiguous() for name, value in tensors.items()}, source)
    subprocess.run([program, weights, source, target], check=True)
    return load_file(target)


def check_superpoint(program, folder, name, network, save, outputs=None):
    print(name)
    weights = os.path.join(folder, name.replace(" ", "_"))
    save(network, weights)
    pixels = inputs.image(120, 160)
    x = torch.tensor(pixels, dtype=torch.float32)[None, None] / 255
    with torch.no_grad():
        maps = outputs(network, x) if outputs else network(x)
        scores, descriptors = networks.dense_maps(*maps)
    actual = run(program, folder, weights, {"image": torch.tensor(pixels)})
    check("scores, largest difference", float((actual["scores"] - scores).abs().max()), TOLERANCE)
    check("scores, relative RMS", relative_rms(actual["scores"], scores), TOLERANCE)
    check("descriptors, relative RMS", relative_rms(actual["descriptors"], descriptors), TOLERANCE)
    for side, cut in {
        "first row": (0,),
        "last row": (-1,),
        "first column": (slice(None), 0),
        "last column": (slice(None), -1),
    }.items():
        check(f"scores of the {side}", relative_rms(actual["scores"][cut], scores[cut]), TOLERANCE)
        check(
            f"descriptors of the {side}",
            relative_rms(actual["descriptors"][cut], descriptors[cut]),
            TOLERANCE,
        )


def check_superglue(program, folder, size, **options):
    width, height, count = 640, 480, 200
    network = networks.hugging_face_superglue(size=size, **options)
    networks.randomize(network, 11)
    networks.sharpen(network, damping=0.1, gain=12.0)
    network.config.matching_threshold = 0.2
    first, second = inputs.features(count, size, width, height)
    with torch.no_grad():
        stacked = [torch.stack(pair)[None] for pair in zip(first, second)]
        matches, scores, *_ = network._match_image_pair(
            stacked[0], stacked[2], stacked[1], height, width
        )
    matches, scores = matches[0, 0], scores[0, 0]
    tensors = {"size": torch.tensor([width, height])}
    for i, image in enumerate((first, second)):
        tensors |= dict(zip((f"keypoints{i}", f"scores{i}", f"descriptors{i}"), image))

    published = networks.magic_leap_names(network)
    legacy = dict(_use_new_zipfile_serialization=False)
    files = {
        "superglue, hugging face, safetensors": lambda p: save_file(network.state_dict(), p),
        "superglue, published names, zip": lambda p: torch.save(published, p),
        "superglue, published names, legacy": lambda p: torch.save(published, p, **legacy),
    }
    for name, save in files.items():
        print(name)
        weights = os.path.join(folder, name.replace(" ", "_"))
        save(weights)
        actual = run(program, folder, weights, tensors)
        print(f"  {int((matches >= 0).sum())} matches, {os.path.getsize(weights)} bytes")
        check("matches that differ", int((actual["matches0"] != matches).sum()), 0)
        check(
            "matching scores, largest difference",
            float((actual["matching_scores0"] - scores).abs().max()),
            TOLERANCE,
        )
    if int((matches >= 0).sum()) < count // 4:
        failures.append("too few matches to compare")


def export(network, path):
    import make_golden

    make_golden.export(network, [torch.zeros(1, 1, 120, 160)], path)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run-network", required=True)
    parser.add_argument("--small", action="store_true", help="narrow and shallow networks")
    arguments = parser.parse_args()
    sizes = dict(widths=(16, 16, 24, 24), head=32, size=64) if arguments.small else {}
    glue = dict(size=64, encoder=(16, 32), layers=4) if arguments.small else dict(size=256)
    legacy = dict(_use_new_zipfile_serialization=False)
    program = os.path.abspath(arguments.run_network)

    with tempfile.TemporaryDirectory() as folder:
        superpoint = lambda *rest: check_superpoint(program, folder, *rest)
        network = networks.randomize(networks.hugging_face_superpoint(**sizes), 1)
        superpoint(
            "superpoint, hugging face, safetensors",
            network,
            lambda n, p: save_file(n.state_dict(), p),
            networks.hugging_face_superpoint_outputs,
        )
        network = networks.randomize(networks.MagicLeapSuperPoint(**sizes), 2)
        superpoint(
            "superpoint, published names, zip", network, lambda n, p: torch.save(n.state_dict(), p)
        )
        network = networks.randomize(networks.RpautratSuperPoint(**sizes), 3)
        superpoint(
            "superpoint, rpautrat, legacy",
            network,
            lambda n, p: torch.save({"model": n.state_dict()}, p, **legacy),
        )
        superpoint(
            "superpoint, rpautrat, zip", network, lambda n, p: torch.save(n.state_dict(), p)
        )
        superpoint("superpoint, rpautrat, onnx", network, export)
        network = networks.randomize(networks.PytorchSuperpoint(**sizes), 4)
        superpoint(
            "superpoint, batch norm before ReLU, zip",
            network,
            lambda n, p: torch.save({"model_state_dict": n.state_dict()}, p),
        )
        superpoint("superpoint, batch norm folded, onnx", network, export)
        check_superglue(program, folder, **glue)
    print(f"{len(failures)} failed" + "".join(f"\n  {what}" for what in failures))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
