"""Random SuperGlues in torch, under the names of each dialect.

Written from the paper (Sarlin et al. 2020) and from the names that published files have; the
Hugging Face one is transformers' own. All return what gluevo computes: the logarithm of the
assignment matrix, by log_assignment.
"""

import torch
from networks import holder
from superpoints import hugging_face_superpoint
from torch import nn


def normalized_keypoints(keypoints, width, height):
    size = torch.tensor([width, height], dtype=keypoints.dtype)
    return (keypoints - size / 2) / (0.7 * size.max())


def log_assignment(scores, dustbin, iterations=100):
    """Sinkhorn in the log domain of [n0 x n1] scores; returns [n0 + 1 x n1 + 1], where a row sums
    to 1 and the dustbin's to n1."""
    n0, n1 = scores.shape
    bins = dustbin.reshape(1, 1)
    z = torch.cat(
        [
            torch.cat([scores, bins.expand(n0, 1)], 1),
            torch.cat([bins.expand(1, n1), bins], 1),
        ],
        0,
    )
    ones = torch.ones_like
    log_mu = torch.cat([ones(z[:-1, 0]), ones(z[0, :-1]).sum()[None]]).log()
    log_nu = torch.cat([ones(z[0, :-1]), ones(z[:-1, 0]).sum()[None]]).log()
    v = torch.zeros_like(log_nu)
    for _ in range(iterations):
        u = log_mu - torch.logsumexp(z + v[None], 1)
        v = log_nu - torch.logsumexp(z + u[:, None], 0)
    return z + u[:, None] + v[None]


class Attention(nn.Module):
    """Published channels are d * heads + head."""

    def __init__(self, size, heads):
        super().__init__()
        self.proj = nn.ModuleList([nn.Conv1d(size, size, 1) for _ in range(3)])
        self.merge = nn.Conv1d(size, size, 1)
        self.heads = heads

    def forward(self, x, source):
        size = x.shape[1]
        split = lambda t: t.reshape(1, size // self.heads, self.heads, -1).permute(0, 2, 3, 1)
        q, k, v = (split(p(t)) for p, t in zip(self.proj, (x, source, source)))
        weights = torch.softmax(q @ k.transpose(2, 3) / (size // self.heads) ** 0.5, 3)
        return self.merge((weights @ v).permute(0, 3, 1, 2).reshape(1, size, -1))


class Layer(nn.Module):
    def __init__(self, size, heads):
        super().__init__()
        self.attn = Attention(size, heads)
        self.mlp = nn.Sequential(
            nn.Conv1d(2 * size, 2 * size, 1),
            nn.BatchNorm1d(2 * size),
            nn.ReLU(),
            nn.Conv1d(2 * size, size, 1),
        )

    def forward(self, x, source):
        return x + self.mlp(torch.cat([x, self.attn(x, source)], 1))


class MagicLeapSuperGlue(nn.Module):
    def __init__(self, size=256, encoder=(32, 64, 128, 256), layers=18, heads=4):
        super().__init__()
        modules = []
        channels = 3
        for width in encoder:
            modules += [nn.Conv1d(channels, width, 1), nn.BatchNorm1d(width), nn.ReLU()]
            channels = width
        modules.append(nn.Conv1d(channels, size, 1))
        self.kenc = holder(encoder=nn.Sequential(*modules))
        self.gnn = holder(layers=nn.ModuleList([Layer(size, heads) for _ in range(layers)]))
        self.final_proj = nn.Conv1d(size, size, 1)
        self.bin_score = nn.Parameter(torch.tensor(1.0))

    def scores(self, keypoints0, scores0, descriptors0, keypoints1, scores1, descriptors1):
        """Normalised keypoints [N x 2], scores [N] and descriptors [N x D] of two images."""
        images = []
        for keypoints, confidence, descriptors in (
            (keypoints0, scores0, descriptors0),
            (keypoints1, scores1, descriptors1),
        ):
            inputs = torch.cat([keypoints.t(), confidence[None]], 0)[None]
            images.append(descriptors.t()[None] + self.kenc.encoder(inputs))
        x, y = images
        for i, layer in enumerate(self.gnn.layers):
            x, y = (layer(x, y), layer(y, x)) if i % 2 else (layer(x, x), layer(y, y))
        x, y = self.final_proj(x)[0], self.final_proj(y)[0]
        return x.t() @ y / x.shape[0] ** 0.5

    forward = scores


def hugging_face_superglue(size=256, encoder=(32, 64, 128, 256), layers=18, heads=4, **superpoint):
    from transformers import SuperGlueConfig, SuperGlueForKeypointMatching

    return SuperGlueForKeypointMatching(
        SuperGlueConfig(
            keypoint_detector_config=hugging_face_superpoint(**superpoint).config,
            hidden_size=size,
            keypoint_encoder_sizes=list(encoder),
            gnn_layers_types=["self", "cross"] * (layers // 2),
            num_attention_heads=heads,
        )
    )


def hugging_face_scores(model, *features):
    """Scores before Sinkhorn by transformers' modules."""
    images = []
    for keypoints, confidence, descriptors in (features[:3], features[3:]):
        encoded = model.keypoint_encoder(keypoints[None], confidence[None])
        images.append(descriptors[None] + (encoded[0] if isinstance(encoded, tuple) else encoded))
    # The graph network wants both images in one batch, of the same number of keypoints.
    n = [image.shape[1] for image in images]
    assert n[0] == n[1], n
    x = model.gnn(torch.cat(images, 0))[0]
    x = model.final_projection(x)
    return x[0] @ x[1].t() / x.shape[2] ** 0.5


def magic_leap_names(model):
    """The state dict of a Hugging Face SuperGlue under the published names, for files that only
    torch reads."""
    heads = model.config.num_attention_heads
    state = {}
    for name, value in model.state_dict().items():
        if name.startswith("keypoint_detector."):
            continue
        parts = name.split(".")
        if name.startswith("keypoint_encoder."):
            module = 3 * int(parts[2]) + (1 if parts[3] == "batch_norm" else 0)
            new = f"kenc.encoder.{module}.{parts[-1]}"
        elif name.startswith("gnn."):
            layer = ".".join(parts[:3])
            if "self" in parts:
                index = ["query", "key", "value"].index(parts[5])
                size = value.shape[0]
                value = value.reshape(heads, size // heads, -1).transpose(0, 1)
                value = value.reshape(size, *([-1] if parts[-1] == "weight" else []))
                new = f"{layer}.attn.proj.{index}.{parts[-1]}"
            elif "dense" in parts:
                if parts[-1] == "weight":
                    size = value.shape[1]
                    value = value.reshape(-1, heads, size // heads).transpose(1, 2)
                    value = value.reshape(-1, size)
                new = f"{layer}.attn.merge.{parts[-1]}"
            elif parts[4] == "0":
                new = f"{layer}.mlp.{1 if parts[5] == 'batch_norm' else 0}.{parts[-1]}"
            else:
                new = f"{layer}.mlp.3.{parts[-1]}"
        elif name.startswith("final_projection."):
            new = f"final_proj.{parts[-1]}"
        else:
            new = name
        if value.dim() == 2:
            value = value[:, :, None]
        state[new] = value.contiguous()
    return state
