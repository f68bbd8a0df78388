"""What the random SuperPoints (superpoints.py) and SuperGlues (superglues.py) share."""

import importlib.metadata

import torch
from torch import nn


def admit_torch_1():
    """transformers looks at torch's version and does without any before 2.0. Its SuperPoint and
    SuperGlue need nothing of 2.0, and Debian 12 has 1.13."""
    version_of = importlib.metadata.version
    if int(torch.__version__.split(".")[0]) < 2:
        importlib.metadata.version = lambda name: "2.0.0" if name == "torch" else version_of(name)


admit_torch_1()


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


def holder(**children):
    module = nn.Module()
    for name, child in children.items():
        module.add_module(name, child)
    return module
