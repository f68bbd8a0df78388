"""PyTorch, whose convolutions and products are oneDNN's, with torchvision's deformable
convolution, as ALIKED was published."""

import importlib.metadata
from collections.abc import Callable

import numpy as np
import torch
import torch.nn.functional as F
from torchvision.ops import deform_conv2d

from . import aliked as aliked_weights
from .aliked import Aliked, Convolution

NAME = "torch"
VERSION = importlib.metadata.version("torch").split("+")[0]
PRECISIONS = ("fp32",)


def _tensor(array: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(np.ascontiguousarray(array, np.float32))


class _Dense(torch.nn.Module):
    def __init__(self, network: Aliked) -> None:
        super().__init__()
        self._network = network
        self._tensors: dict[int, torch.Tensor] = {}

    def _of(self, array: np.ndarray) -> torch.Tensor:
        if id(array) not in self._tensors:
            self._tensors[id(array)] = _tensor(array)
        return self._tensors[id(array)]

    def _layer(self, value: torch.Tensor, convolution: Convolution) -> torch.Tensor:
        weight, bias = self._of(convolution.map.weight), self._of(convolution.map.bias)
        if convolution.offsets is None:
            return F.conv2d(value, weight, bias, padding=1)
        offsets = convolution.offsets
        moves = F.conv2d(value, self._of(offsets.weight), self._of(offsets.bias), padding=1)
        largest = aliked_weights.largest_offset(*value.shape[2:])
        moves = moves.clamp(-largest, largest)
        return deform_conv2d(value, moves, weight, bias, padding=(1, 1))

    def forward(self, image: torch.Tensor) -> list[torch.Tensor]:
        height, width = image.shape[2:]
        top, bottom = aliked_weights.padding(height)
        left, right = aliked_weights.padding(width)
        value = F.pad(image, [left, right, top, bottom], mode="replicate")
        branches = []
        for block, pool, scale, branch in zip(
            self._network.blocks,
            aliked_weights.POOLS,
            aliked_weights.SCALES,
            self._network.branches,
        ):
            value = F.avg_pool2d(value, pool) if pool > 1 else value
            whole = self._layer(F.selu(self._layer(value, block.first), inplace=True), block.second)
            if block.shortcut is not None:
                shortcut = self._of(block.shortcut.weight), self._of(block.shortcut.bias)
                whole = whole + F.conv2d(value, *shortcut)
            value = F.selu(whole, inplace=True)
            seen = F.selu(F.conv2d(value, self._of(branch)), inplace=True)
            if scale > 1:
                seen = F.interpolate(seen, scale_factor=scale, mode="bilinear", align_corners=True)
            branches.append(seen)
        features = torch.cat(branches, dim=1)
        scores = features
        for index, weight in enumerate(self._network.score_head):
            scores = F.conv2d(scores, self._of(weight), padding=weight.shape[2] // 2)
            is_last = index == len(self._network.score_head) - 1
            scores = torch.sigmoid(scores) if is_last else F.selu(scores, inplace=True)
        features = F.normalize(features, dim=1)
        inner = (..., slice(top, top + height), slice(left, left + width))
        return [scores[inner], features[inner]]


def aliked(
    network: Aliked, image: np.ndarray, precision: str, threads: int
) -> Callable[[], list[torch.Tensor]]:
    torch.set_num_threads(threads)
    dense = _Dense(network)
    tensor = _tensor(image[None, None])

    def run() -> list[torch.Tensor]:
        with torch.inference_mode():
            return dense(tensor)

    return run


def to_array(value: torch.Tensor) -> np.ndarray:
    return value.numpy()
