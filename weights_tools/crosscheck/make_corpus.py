#!/usr/bin/env python3
"""The seeds of the fuzzers: whole files of each form, as small as networks of these shapes can be.

    python3 weights_tools/crosscheck/make_corpus.py [--out tests/fuzz/corpus]
"""

import argparse
import os
import tempfile
import zipfile

import make_container_files
import make_golden
import networks
import numpy as np
import open_networks
import superglues
import superpoints
import torch
from safetensors.torch import save_file

WIDTHS = dict(widths=(1, 1, 1, 1), head=1, size=1)
GLUE = dict(size=4, encoder=(2,), layers=2, heads=4)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="tests/fuzz/corpus")
    out = parser.parse_args().out

    def path(harness, name):
        os.makedirs(os.path.join(out, harness), exist_ok=True)
        return os.path.join(out, harness, name)

    legacy = dict(_use_new_zipfile_serialization=False)
    glue = networks.randomize(superglues.MagicLeapSuperGlue(**GLUE), 1)
    random_superpoints = {
        "magic_leap": superpoints.MagicLeapSuperPoint(**WIDTHS),
        "rpautrat": superpoints.RpautratSuperPoint(**WIDTHS),
        "batch_norm": superpoints.PytorchSuperpoint(**WIDTHS),
        "hugging_face": superglues.hugging_face_superglue(
            **GLUE, widths=WIDTHS["widths"], head=WIDTHS["head"]
        ),
    }
    for seed, (name, network) in enumerate(random_superpoints.items()):
        networks.randomize(network, seed)
        save_file(network.state_dict(), path("container", f"{name}.safetensors"))
    state = {"module." + name: value.half() for name, value in glue.state_dict().items()}
    for name in [name for name in state if name.endswith("num_batches_tracked")]:
        del state[name]
    save_file(state, path("container", "superglue_half.safetensors"))
    torch.save({"model": glue.state_dict()}, path("container", "superglue_legacy.pth"), **legacy)

    for name in ("aliked", "lightglue"):
        shapes = getattr(open_networks, name)()
        state = {key: torch.ones(shape).half() for key, shape in shapes.items()}
        for harness in ("container", "open_networks"):
            save_file(state, path(harness, f"{name}.safetensors"))

    arrays = {"c": np.ones((2, 1), "<f4"), "f": np.asfortranarray(np.ones((2, 3), "<f2"))}
    for name, array in arrays.items():
        np.save(path("npy", f"{name}.npy"), array)
        with open(path("npy", f"{name}_3.npy"), "wb") as file:
            np.lib.format.write_array(file, array.astype("<f8"), version=(3, 0))
    np.savez(path("npz", "stored.npz"), **arrays)
    np.savez_compressed(path("npz", "deflated.npz"), **arrays)
    save_file({"w": torch.ones(2, 1), "half": torch.ones(1).half()}, path("safetensors", "two"),
              metadata={"note": "a \"text\""})

    tensors = make_container_files.tensors()
    torch.save(tensors, path("torch_legacy", "tensors.pth"), **legacy)
    torch.save({"state_dict": tensors, "epoch": 1.5}, path("torch_legacy", "wrapped.pth"), **legacy)
    with tempfile.TemporaryDirectory() as folder:
        for protocol in (2, 4):
            name = os.path.join(folder, "file.pth")
            torch.save({"net": tensors}, name, pickle_protocol=protocol)
            with zipfile.ZipFile(name) as archive, open(path("pickle", f"{protocol}"), "wb") as file:
                file.write(archive.read("file/data.pkl"))
            if protocol == 2:
                with open(name, "rb") as source, open(path("npz", "torch.pth"), "wb") as file:
                    file.write(source.read())

    image = torch.zeros(1, 1, 16, 16)
    for name in ("magic_leap", "rpautrat", "batch_norm"):
        make_golden.export(random_superpoints[name], [image], path("onnx", f"{name}.onnx"))
    pixels = np.arange(256, dtype=np.uint8).reshape(16, 16)
    make_golden.make_int8(random_superpoints["magic_leap"], pixels, path("onnx", "int8.onnx"))
    qlinear = path("onnx", "qlinear.onnx")
    make_golden.make_int8(random_superpoints["magic_leap"], pixels, qlinear, operators=True)
    features = [torch.rand(2, 2), torch.rand(2), torch.rand(2, GLUE["size"])] * 2
    network = make_golden.WithAssignment(glue, lambda net, *inputs: net(*inputs))
    make_golden.export(network, features, path("onnx", "superglue.onnx"), keypoints=True)
    for folder, _, names in os.walk(out):
        for name in names:
            os.chmod(os.path.join(folder, name), 0o644)


if __name__ == "__main__":
    main()
