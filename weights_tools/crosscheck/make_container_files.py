#!/usr/bin/env python3
"""Small files of tensors as PyTorch writes them, for the tests of the readers.

    python3 weights_tools/crosscheck/make_container_files.py [--out tests/data/weights]

All good files hold the same tensors; tests/weights_tools/torch_test.cc names their values.
"""

import argparse
import collections
import os

import torch


def tensors():
    base = torch.arange(12, dtype=torch.float32).reshape(3, 4) / 2
    return collections.OrderedDict(
        plain=base,
        transposed=base.t(),  # Shares the storage of plain, in other strides.
        part=base[1:, 2:],  # The same, from an offset on.
        half=torch.tensor([1.5, -2.0, 2.0**-24], dtype=torch.float16),
        brain=torch.tensor([1.5, -3.0], dtype=torch.bfloat16),
        wide=torch.tensor([0.1], dtype=torch.float64),
        parameter=torch.nn.Parameter(torch.tensor([[7.0]])),
        scalar=torch.tensor(-3.0),
        **{"bn.num_batches_tracked": torch.tensor(5)},
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="tests/data/weights")
    out = parser.parse_args().out
    path = lambda name: os.path.join(out, name)
    legacy = dict(_use_new_zipfile_serialization=False)

    torch.save(tensors(), path("torch.pth"))
    torch.save({"state_dict": tensors(), "epoch": 3, "loss": torch.ones(1)}, path("torch_wrapped.pth"))
    torch.save(tensors(), path("torch_protocol4.pth"), pickle_protocol=4)
    torch.save(tensors(), path("torch_legacy.pth"), **legacy)
    torch.save({"model": {"net": tensors()}}, path("torch_legacy_wrapped.pth"), **legacy)

    torch.save(torch.nn.Conv2d(1, 1, 1), path("torch_module.pth"))
    torch.jit.save(torch.jit.script(torch.nn.Conv2d(1, 1, 1)), path("torch_script.pt"))
    torch.save({"w": torch.arange(3)}, path("torch_integers.pth"))
    torch.save({"epoch": 3, "note": "none"}, path("torch_no_tensors.pth"))


if __name__ == "__main__":
    main()
