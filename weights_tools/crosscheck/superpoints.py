"""Random SuperPoints in torch, under the names of each dialect.

Written from the paper (DeTone et al. 2018) and from the names that published files have; the
Hugging Face one is transformers' own. All return what gluevo computes: the dense score map and the
dense unit descriptors, by dense_maps.
"""

import torch
from networks import holder
from torch import nn
from torch.nn import functional as F


def dense_maps(logits, descriptors):
    """[1 x 65 x h x w] and [1 x D x h x w] to [8 h x 8 w] and [h x w x D]."""
    scores = torch.softmax(logits, 1)[:, :64]
    scores = F.pixel_shuffle(scores, 8)[0, 0]
    return scores, F.normalize(descriptors, dim=1)[0].permute(1, 2, 0)


class MagicLeapSuperPoint(nn.Module):
    def __init__(self, widths=(64, 64, 128, 128), head=256, size=256):
        super().__init__()
        channels = 1
        for stage, width in enumerate(widths, 1):
            for part in "ab":
                setattr(self, f"conv{stage}{part}", nn.Conv2d(channels, width, 3, padding=1))
                channels = width
        self.convPa = nn.Conv2d(channels, head, 3, padding=1)
        self.convPb = nn.Conv2d(head, 65, 1)
        self.convDa = nn.Conv2d(channels, head, 3, padding=1)
        self.convDb = nn.Conv2d(head, size, 1)
        self.stages = len(widths)

    def forward(self, x):
        for stage in range(1, self.stages + 1):
            for part in "ab":
                x = torch.relu(getattr(self, f"conv{stage}{part}")(x))
            if stage < self.stages:
                x = F.max_pool2d(x, 2)
        logits = self.convPb(torch.relu(self.convPa(x)))
        return logits, self.convDb(torch.relu(self.convDa(x)))


class Block(nn.Module):
    """Convolution, ReLU, batch norm, under rpautrat's names."""

    def __init__(self, inputs, outputs, kernel, relu=True):
        super().__init__()
        self.conv = nn.Conv2d(inputs, outputs, kernel, padding=kernel // 2)
        self.bn = nn.BatchNorm2d(outputs, eps=1e-3)
        self.relu = relu

    def forward(self, x):
        x = self.conv(x)
        return self.bn(torch.relu(x) if self.relu else x)


class RpautratSuperPoint(nn.Module):
    def __init__(self, widths=(64, 64, 128, 128), head=256, size=256):
        super().__init__()
        inputs = (1, *widths[:-1])
        self.backbone = nn.Sequential(
            *(nn.Sequential(Block(a, b, 3), Block(b, b, 3)) for a, b in zip(inputs, widths))
        )
        self.detector = nn.Sequential(Block(widths[-1], head, 3), Block(head, 65, 1, relu=False))
        self.descriptor = nn.Sequential(Block(widths[-1], head, 3), Block(head, size, 1, relu=False))

    def forward(self, x):
        for i, stage in enumerate(self.backbone):
            x = stage(x)
            if i + 1 < len(self.backbone):
                x = F.max_pool2d(x, 2)
        return self.detector(x), self.descriptor(x)


def double_convolution(inputs, outputs):
    layers = []
    for channels in (inputs, outputs):
        layers += [nn.Conv2d(channels, outputs, 3, padding=1), nn.BatchNorm2d(outputs), nn.ReLU()]
    return nn.Sequential(*layers)


class PytorchSuperpoint(nn.Module):
    """Convolution, batch norm, ReLU, under the names of pytorch-superpoint."""

    def __init__(self, widths=(64, 64, 128, 128), head=256, size=256):
        super().__init__()
        self.inc = holder(conv=holder(conv=double_convolution(1, widths[0])))
        for i in range(1, len(widths)):
            inner = holder(conv=double_convolution(widths[i - 1], widths[i]))
            setattr(self, f"down{i}", holder(mpconv=nn.Sequential(nn.MaxPool2d(2), inner)))
        for head_name, outputs in (("P", 65), ("D", size)):
            setattr(self, f"conv{head_name}a", nn.Conv2d(widths[-1], head, 3, padding=1))
            setattr(self, f"bn{head_name}a", nn.BatchNorm2d(head))
            setattr(self, f"conv{head_name}b", nn.Conv2d(head, outputs, 1))
            setattr(self, f"bn{head_name}b", nn.BatchNorm2d(outputs))
        self.stages = len(widths)

    def forward(self, x):
        x = self.inc.conv.conv(x)
        for i in range(1, self.stages):
            pool, inner = getattr(self, f"down{i}").mpconv
            x = inner.conv(pool(x))
        logits = self.bnPb(self.convPb(torch.relu(self.bnPa(self.convPa(x)))))
        return logits, self.bnDb(self.convDb(torch.relu(self.bnDa(self.convDa(x)))))


def hugging_face_superpoint(widths=(64, 64, 128, 128), head=256, size=256):
    from transformers import SuperPointConfig, SuperPointForKeypointDetection

    return SuperPointForKeypointDetection(
        SuperPointConfig(
            encoder_hidden_sizes=list(widths),
            decoder_hidden_size=head,
            descriptor_decoder_dim=size,
        )
    )


def hugging_face_superpoint_outputs(model, x):
    """Its layers without its keypoint selection, which gives no dense maps."""
    x = model.encoder(x).last_hidden_state
    keypoints, descriptors = model.keypoint_decoder, model.descriptor_decoder
    logits = keypoints.conv_score_b(torch.relu(keypoints.conv_score_a(x)))
    return logits, descriptors.conv_descriptor_b(torch.relu(descriptors.conv_descriptor_a(x)))
