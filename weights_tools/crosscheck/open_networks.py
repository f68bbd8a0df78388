"""Shapes of the smallest ALIKED and LightGlue, under their published names."""


def lightglue(size=4, descriptors=3, layers=2):
    shapes = {"posenc.Wr.weight": (size // 4, 2)}

    def linear(name, out, inputs):
        shapes[name + ".weight"] = (out, inputs)
        shapes[name + ".bias"] = (out,)

    linear("input_proj", size, descriptors)
    for i in range(layers):
        own, cross = f"transformers.{i}.self_attn.", f"transformers.{i}.cross_attn."
        linear(own + "Wqkv", 3 * size, size)
        linear(own + "out_proj", size, size)
        for name in ("to_qk", "to_v", "to_out"):
            linear(cross + name, size, size)
        for block in (own, cross):
            linear(block + "ffn.0", 2 * size, 2 * size)
            shapes[block + "ffn.1.weight"] = shapes[block + "ffn.1.bias"] = (2 * size,)
            linear(block + "ffn.3", size, 2 * size)
        linear(f"log_assignment.{i}.matchability", 1, size)
        linear(f"log_assignment.{i}.final_proj", size, size)
        if i + 1 < layers:
            linear(f"token_confidence.{i}.token.0", 1, size)
    return shapes


def aliked(widths=(1, 2, 1, 2), size=64, samples=1):
    shapes = {}

    def convolution(name, out, inputs, side):
        shapes[name + ".weight"] = (out, inputs, side, side)
        shapes[name + ".bias"] = (out,)

    inputs = 3
    for i, out in enumerate(widths, 1):
        for number, channels in ((1, inputs), (2, out)):
            name = f"block{i}.conv{number}"
            plain = name + (".regular_conv" if i > 2 else "")
            shapes[plain + ".weight"] = (out, channels, 3, 3)
            for part in ("weight", "bias", "running_mean", "running_var"):
                shapes[f"block{i}.bn{number}.{part}"] = (out,)
            if i > 2:
                convolution(name + ".offset_conv", 18, channels, 3)
        if i > 1:
            convolution(f"block{i}.downsample", out, inputs, 1)
        shapes[f"conv{i}.weight"] = (size // 4, out, 1, 1)
        inputs = out
    shapes["score_head.0.weight"] = (1, size, 1, 1)
    for layer in (2, 4, 6):
        shapes[f"score_head.{layer}.weight"] = (1, 1, 3, 3)
    shapes["desc_head.agg_weights"] = (samples, size, size)
    shapes["desc_head.sf_conv.weight"] = (size, size, 1, 1)
    convolution("desc_head.offset_conv.0", 2 * samples, size, 3)
    convolution("desc_head.offset_conv.2", 2 * samples, 2 * samples, 1)
    return shapes
