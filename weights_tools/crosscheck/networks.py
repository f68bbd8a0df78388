"""Random SuperPoints and SuperGlues in torch, under the names of each dialect.

Written from the papers (DeTone et al. 2018, Sarlin et al. 2020) and from the names that published
files have; the Hugging Face ones are transformers' own. All return what gluevo computes:
SuperPoints the dense score map and the dense unit descriptors, SuperGlues the logarithm of the
assignment matrix.
"""

import torch
from torch import nn
from torch.nn import functional as F


def randomize(network, seed):
    """Weights that keep a layer's outputs about as large as its inputs, batch norms included."""
    generator = torch.Generator().manual_seed(seed)

    def uniform(tensor, low, high):
        with torch.no_grad():
            tensor.copy_(torch.rand(tensor.shape, generator=generator) * (high - low) + low)

    for module in network.modules():
        if isinstance(module, (nn.Conv1d, nn.Conv2d, nn.Linear)):
            fan_in = module.weight[0].numel()
            bound = (3.0 / fan_in) ** 0.5 * (1.4 if isinstance(module, nn.Conv2d) else 1.0)
            uniform(module.weight, -bound, bound)
            uniform(module.bias, -0.1, 0.1)
        elif isinstance(module, (nn.BatchNorm1d, nn.BatchNorm2d)):
            uniform(module.weight, 0.5, 1.5)
            uniform(module.bias, -0.2, 0.2)
            uniform(module.running_mean, -0.2, 0.2)
            uniform(module.running_var, 0.5, 1.5)
    return network.eval()


def sharpen(network, damping=1.0, gain=3.0):
    """Makes scores of a random Hugging Face SuperGlue follow its descriptors, so that there are
    matches; the deeper it is the less its layers may change them."""
    with torch.no_grad():
        for layer in [network.keypoint_encoder.encoder, *(l.mlp for l in network.gnn.layers)]:
            layer[-1].weight.mul_(damping)
            layer[-1].bias.mul_(damping)
        final = network.final_projection.final_proj
        final.weight.mul_(0.2).add_(gain * torch.eye(final.weight.shape[0]))


# ------------------------------------------------------------------------------------ SuperPoint


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


def holder(**children):
    module = nn.Module()
    for name, child in children.items():
        module.add_module(name, child)
    return module


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


# ------------------------------------------------------------------------------------- SuperGlue


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
