#!/usr/bin/env python3
"""Golden outputs of SuperPoint and SuperGlue, computed independently of the C++ code.

Both networks in float64 with numpy alone, written from the papers (DeTone et al. 2018, "SuperPoint:
Self-Supervised Interest Point Detection and Description"; Sarlin et al. 2020, "SuperGlue: Learning
Feature Matching with Graph Neural Networks") and from the conventions of the published models that
README.md beside this file lists. Nothing is fused, folded or reordered here: every step is the
plainest form of its equation.

    python3 tests/golden/make_golden.py --weights DIR [--out tests/data]

DIR holds the open weights, superpoint.safetensors and superglue.safetensors (nn/open_weights), or
superpoint_narrow.npz and superglue_shallow.npz. Needs numpy only. README.md names every tensor.
"""

import argparse
import json
import os
import struct
import sys

import numpy as np

HEADS = 4
BATCH_NORM_EPS = 1e-5
SINKHORN_ITERATIONS = 100


# ---------------------------------------------------------------------------------------- files


def read_safetensors(path):
    with open(path, "rb") as file:
        data = file.read()
    (header_size,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + header_size])
    body = data[8 + header_size :]
    tensors = {}
    for name, entry in header.items():
        if name == "__metadata__":
            continue
        if entry["dtype"] != "F32":
            raise SystemExit(f"{path}: {name} is {entry['dtype']}, expected F32")
        begin, end = entry["data_offsets"]
        values = np.frombuffer(body[begin:end], "<f4").reshape(entry["shape"])
        tensors[name] = values.astype(np.float64)
    return tensors


def write_safetensors(path, tensors, metadata):
    """F32, names in order, header padded to 8 bytes: the same bytes for the same values."""
    header = {"__metadata__": metadata}
    body = b""
    for name in sorted(tensors):
        values = np.ascontiguousarray(np.asarray(tensors[name]).astype("<f4"))
        if not np.all(np.isfinite(values)):
            raise SystemExit(f"{path}: {name} is not finite")
        raw = values.tobytes()
        header[name] = {
            "dtype": "F32",
            "shape": list(values.shape),
            "data_offsets": [len(body), len(body) + len(raw)],
        }
        body += raw
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)
    with open(path + ".part", "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text + body)
    os.replace(path + ".part", path)
    print(f"{path}: {8 + len(text) + len(body)} bytes")


def read_weights(directory, names):
    for name in names:
        path = os.path.join(directory, name)
        if os.path.exists(path):
            if path.endswith(".npz"):
                with np.load(path) as file:
                    return {key: file[key].astype(np.float64) for key in file.files}
            return read_safetensors(path)
    raise SystemExit(f"{directory}: none of {', '.join(names)} is there")


# ---------------------------------------------------------------------------------------- images


def synthetic_image(width, height, seed):
    """Blocks of hashed gray levels, a brighter square inside some, and noise of a linear
    congruential generator; integers only, so that any language makes the same bytes."""
    mask = 0xFFFFFFFF
    state = seed & mask
    image = np.zeros((height, width), np.uint8)
    for y in range(height):
        for x in range(width):
            block = ((x // 13) * 73856093) ^ ((y // 11) * 19349663) ^ (seed * 83492791)
            block = ((block & mask) * 1664525 + 1013904223) & mask
            block = ((block ^ (block >> 15)) * 2246822519) & mask
            value = 24 + (block >> 24) * 3 // 4
            inside = 3 <= x % 13 < 8 and 4 <= y % 11 < 9
            if inside and (block >> 8) & 1:
                value = (value + 96) % 232
            state = (state * 1664525 + 1013904223) & mask
            image[y, x] = value + (state >> 28)
    return image


def warp_affine(image, matrix):
    """Bilinear; output pixel p shows input pixel matrix * (p, 1); outside is clamped."""
    height, width = image.shape
    y, x = np.mgrid[0:height, 0:width].astype(np.float64)
    u = matrix[0][0] * x + matrix[0][1] * y + matrix[0][2]
    v = matrix[1][0] * x + matrix[1][1] * y + matrix[1][2]
    u = np.clip(u, 0, width - 1.001)
    v = np.clip(v, 0, height - 1.001)
    x0, y0 = np.floor(u).astype(int), np.floor(v).astype(int)
    a, b = u - x0, v - y0
    f = image.astype(np.float64)
    value = (1 - b) * ((1 - a) * f[y0, x0] + a * f[y0, x0 + 1]) + b * (
        (1 - a) * f[y0 + 1, x0] + a * f[y0 + 1, x0 + 1]
    )
    return np.floor(value + 0.5).astype(np.uint8)


# ------------------------------------------------------------------------------------ SuperPoint


def convolve(x, weight, bias):
    """Cross-correlation, C x H x W by O x C x k x k, zero padding that keeps the size."""
    out_channels, _, k, _ = weight.shape
    pad = k // 2
    _, height, width = x.shape
    padded = np.pad(x, ((0, 0), (pad, pad), (pad, pad)))
    y = np.zeros((out_channels, height, width))
    for i in range(k):
        for j in range(k):
            window = padded[:, i : i + height, j : j + width]
            y += np.tensordot(weight[:, :, i, j], window, axes=1)
    return y + bias[:, None, None]


def relu(x):
    return np.maximum(x, 0.0)


def max_pool_2x2(x):
    """A last odd row or column is dropped."""
    _, height, width = x.shape
    x = x[:, : height // 2 * 2, : width // 2 * 2]
    return np.maximum(
        np.maximum(x[:, 0::2, 0::2], x[:, 0::2, 1::2]),
        np.maximum(x[:, 1::2, 0::2], x[:, 1::2, 1::2]),
    )


def unit_length(x, axis):
    return x / np.sqrt(np.sum(x * x, axis=axis, keepdims=True))


def superpoint_dense(weights, image):
    """Scores (8h x 8w, before suppression) and unit coarse descriptors (D x h x w)."""

    def layer(name, x):
        return convolve(x, weights[name + ".weight"], weights[name + ".bias"])

    x = image.astype(np.float64)[None] / 255.0
    for stage in "1234":
        x = relu(layer(f"conv{stage}a", x))
        x = relu(layer(f"conv{stage}b", x))
        if stage != "4":
            x = max_pool_2x2(x)
    logits = layer("convPb", relu(layer("convPa", x)))
    logits = logits - logits.max(axis=0, keepdims=True)
    probability = np.exp(logits) / np.exp(logits).sum(axis=0, keepdims=True)
    _, h, w = probability.shape
    scores = np.zeros((8 * h, 8 * w))
    for channel in range(64):  # The 65th, "no keypoint", is dropped.
        scores[channel // 8 :: 8, channel % 8 :: 8] = probability[channel]
    descriptors = unit_length(layer("convDb", relu(layer("convDa", x))), axis=0)
    return scores, descriptors


def window_max(x, radius):
    height, width = x.shape
    padded = np.pad(x, radius, constant_values=-np.inf)
    y = np.full_like(x, -np.inf)
    for i in range(2 * radius + 1):
        for j in range(2 * radius + 1):
            y = np.maximum(y, padded[i : i + height, j : j + width])
    return y


def suppress(scores, radius=4):
    """Maxima of their window; then, twice, maxima of what no kept point's window covers."""
    keep = scores == window_max(scores, radius)
    for _ in range(2):
        covered = window_max(keep.astype(np.float64), radius) > 0
        rest = np.where(covered, 0.0, scores)
        keep |= (rest == window_max(rest, radius)) & ~covered
    return np.where(keep, scores, 0.0)


def sample_descriptors(keypoints, dense):
    """Bilinear at (kp - 3.5) / (8 size - 4.5) of the way between the outer cell centres."""
    _, h, w = dense.shape
    x = (keypoints[:, 0] - 3.5) / (8 * w - 4.5) * (w - 1)
    y = (keypoints[:, 1] - 3.5) / (8 * h - 4.5) * (h - 1)
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    a, b = x - x0, y - y0
    x1, y1 = np.minimum(x0 + 1, w - 1), np.minimum(y0 + 1, h - 1)
    d = dense[:, y0, x0] * (1 - a) * (1 - b) + dense[:, y0, x1] * a * (1 - b)
    d += dense[:, y1, x0] * (1 - a) * b + dense[:, y1, x1] * a * b
    return unit_length(d, axis=0).T  # N x D


def select_keypoints(scores, threshold, border=4):
    """Row by row, left to right."""
    height, width = scores.shape
    suppressed = suppress(scores)
    y, x = np.nonzero(suppressed > threshold)
    inside = (x >= border) & (x < width - border) & (y >= border) & (y < height - border)
    x, y = x[inside], y[inside]
    return np.stack([x, y], axis=1), suppressed[y, x]


def check_margins(scores, threshold):
    """The same keypoints must come out where scores carry errors of 1e-5 of themselves."""
    keypoints, _ = select_keypoints(scores, threshold)
    rng = np.random.default_rng(0)
    for _ in range(20):
        noisy = scores * (1 + 1e-5 * rng.uniform(-1, 1, scores.shape))
        again, _ = select_keypoints(noisy, threshold)
        if not np.array_equal(keypoints, again):
            raise SystemExit("the keypoints hang on the last digits of the scores: change the seed")


def superpoint(weights, image, threshold):
    scores, dense = superpoint_dense(weights, image)
    check_margins(scores, threshold)
    keypoints, keypoint_scores = select_keypoints(scores, threshold)
    return {
        "image": image,
        "score_map": scores,
        "descriptor_map": dense,
        "keypoints": keypoints,
        "scores": keypoint_scores,
        "descriptors": sample_descriptors(keypoints, dense),
    }


# ------------------------------------------------------------------------------------- SuperGlue


def linear(weights, name, x):
    """A 1x1 convolution over N x C."""
    weight = weights[name + ".weight"].reshape(weights[name + ".weight"].shape[:2])
    return x @ weight.T + weights[name + ".bias"]


def batch_norm(weights, name, x):
    mean, variance = weights[name + ".running_mean"], weights[name + ".running_var"]
    scaled = (x - mean) / np.sqrt(variance + BATCH_NORM_EPS)
    return scaled * weights[name + ".weight"] + weights[name + ".bias"]


def keypoint_encoder(weights, keypoints, scores, size):
    """size is (width, height); input (x, y, score)."""
    size = np.asarray(size, np.float64)
    x = np.concatenate([(keypoints - size / 2) / (0.7 * size.max()), scores[:, None]], axis=1)
    index = 0
    while True:
        x = linear(weights, f"kenc.encoder.{index}", x)
        if f"kenc.encoder.{index + 3}.weight" not in weights:
            return x
        x = relu(batch_norm(weights, f"kenc.encoder.{index + 1}", x))
        index += 3


def softmax_rows(x):
    e = np.exp(x - x.max(axis=1, keepdims=True))
    return e / e.sum(axis=1, keepdims=True)


def propagate(weights, layer, x, source):
    """What one attentional layer adds to x (N x D), attending to source (M x D)."""
    prefix = f"gnn.layers.{layer}."
    query = linear(weights, prefix + "attn.proj.0", x)
    key = linear(weights, prefix + "attn.proj.1", source)
    value = linear(weights, prefix + "attn.proj.2", source)
    message = np.zeros_like(x)
    depth = x.shape[1] // HEADS
    for head in range(HEADS):
        # Channel = d * HEADS + head, as in the published checkpoints.
        channels = slice(head, None, HEADS)
        logits = query[:, channels] @ key[:, channels].T / np.sqrt(depth)
        message[:, channels] = softmax_rows(logits) @ value[:, channels]
    message = linear(weights, prefix + "attn.merge", message)
    y = linear(weights, prefix + "mlp.0", np.concatenate([x, message], axis=1))
    y = relu(batch_norm(weights, prefix + "mlp.1", y))
    return linear(weights, prefix + "mlp.3", y)


def log_sum_exp(x, axis):
    largest = x.max(axis=axis, keepdims=True)
    return np.squeeze(largest + np.log(np.exp(x - largest).sum(axis=axis, keepdims=True)), axis)


def log_assignment(scores, dustbin):
    """(M + 1) x (N + 1): log of the optimal partial assignment, times (M + N)."""
    m, n = scores.shape
    couplings = np.full((m + 1, n + 1), dustbin)
    couplings[:m, :n] = scores
    log_mu = np.concatenate([np.zeros(m), [np.log(n)]]) - np.log(m + n)
    log_nu = np.concatenate([np.zeros(n), [np.log(m)]]) - np.log(m + n)
    u, v = np.zeros(m + 1), np.zeros(n + 1)
    for _ in range(SINKHORN_ITERATIONS):
        u = log_mu - log_sum_exp(couplings + v[None, :], axis=1)
        v = log_nu - log_sum_exp(couplings + u[:, None], axis=0)
    return couplings + u[:, None] + v[None, :] + np.log(m + n)


def mutual_best(assignment, threshold):
    inner = assignment[:-1, :-1]
    best0, best1 = inner.argmax(axis=1), inner.argmax(axis=0)
    mutual = best1[best0] == np.arange(len(best0))
    mutual_scores = np.where(mutual, np.exp(inner.max(axis=1)), 0.0)
    valid = mutual & (mutual_scores > threshold)
    close = np.abs(mutual_scores - threshold) < 1e-3
    ordered = np.sort(inner, axis=1)
    if inner.shape[1] > 1:
        close |= mutual & (ordered[:, -1] - ordered[:, -2] < 1e-3)
    if close.any():
        raise SystemExit("a match hangs on the last digits: change the seed")
    return np.where(valid, best0, -1), np.where(valid, mutual_scores, 0.0), mutual_scores


def superglue(weights, features0, features1, threshold, steps):
    """steps: the layers after which the descriptors are kept."""
    out = {}
    x = []
    for i, features in enumerate((features0, features1)):
        # What the C++ code reads is float32: both sides start from the same values.
        features = {k: np.asarray(v).astype(np.float32).astype(np.float64)
                    for k, v in features.items()}
        for key in ("keypoints", "scores", "descriptors", "size"):
            out[f"{key}{i}"] = features[key]
        encoded = keypoint_encoder(
            weights, features["keypoints"], features["scores"], features["size"])
        x.append(features["descriptors"] + encoded)
        out[f"encoded{i}"] = x[i]
    layer = 0
    while f"gnn.layers.{layer}.mlp.0.weight" in weights:
        cross = layer % 2 == 1
        delta0 = propagate(weights, layer, x[0], x[1] if cross else x[0])
        delta1 = propagate(weights, layer, x[1], x[0] if cross else x[1])
        x = [x[0] + delta0, x[1] + delta1]
        if layer in steps:
            out[f"layer{layer}_0"], out[f"layer{layer}_1"] = x
        layer += 1
    projected0 = linear(weights, "final_proj", x[0])
    projected1 = linear(weights, "final_proj", x[1])
    scores = projected0 @ projected1.T / np.sqrt(x[0].shape[1])
    out["pair_scores"] = scores
    out["log_assignment"] = log_assignment(scores, float(weights["bin_score"]))
    out["matches0"], out["matching_scores0"], out["mutual_scores0"] = mutual_best(
        out["log_assignment"], threshold)
    return out


def random_superglue(seed, width, encoder, layers):
    """Another configuration than the published one; values round in float32."""
    rng = np.random.default_rng(seed)
    weights = {}

    def add_linear(name, inputs, outputs, gain=1.0):
        weight = rng.standard_normal((outputs, inputs, 1)) * gain / np.sqrt(inputs)
        weights[name + ".weight"] = weight
        weights[name + ".bias"] = rng.standard_normal(outputs) * 0.1

    def add_norm(name, channels):
        weights[name + ".weight"] = rng.uniform(0.5, 1.5, channels)
        weights[name + ".bias"] = rng.standard_normal(channels) * 0.1
        weights[name + ".running_mean"] = rng.standard_normal(channels) * 0.2
        weights[name + ".running_var"] = rng.uniform(0.3, 2.0, channels)

    channels = [3] + encoder + [width]
    for i, (inputs, outputs) in enumerate(zip(channels[:-1], channels[1:])):
        add_linear(f"kenc.encoder.{3 * i}", inputs, outputs)
        if i < len(channels) - 2:
            add_norm(f"kenc.encoder.{3 * i + 1}", outputs)
    for i in range(layers):
        for j in range(3):
            add_linear(f"gnn.layers.{i}.attn.proj.{j}", width, width, gain=2.0 if j < 2 else 1.0)
        add_linear(f"gnn.layers.{i}.attn.merge", width, width)
        add_linear(f"gnn.layers.{i}.mlp.0", 2 * width, 2 * width)
        add_norm(f"gnn.layers.{i}.mlp.1", 2 * width)
        add_linear(f"gnn.layers.{i}.mlp.3", 2 * width, width)
    add_linear("final_proj", width, width, gain=2.0)
    weights["bin_score"] = np.array(1.5)
    return {k: v.astype(np.float32).astype(np.float64) for k, v in weights.items()}


def random_features(rng, count, width, size):
    return {
        "keypoints": rng.integers(4, np.asarray(size) - 4, (count, 2)),
        "scores": rng.uniform(0.01, 0.9, count),
        "descriptors": unit_length(rng.standard_normal((count, width)), axis=1),
        "size": np.array(size),
    }


# ------------------------------------------------------------------------------------------ main


def best_features(weights, image, count):
    result = superpoint(weights, image, 0.005)
    if len(result["scores"]) < count:
        raise SystemExit(f"only {len(result['scores'])} keypoints, {count} are needed")
    order = np.argsort(-result["scores"], kind="stable")[:count]
    features = {key: result[key][order] for key in ("keypoints", "scores", "descriptors")}
    features["size"] = np.array([image.shape[1], image.shape[0]])
    return features


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--weights", required=True, help="folder of the open weights")
    parser.add_argument("--out", default=os.path.join(os.path.dirname(__file__), "..", "data"))
    options = parser.parse_args()
    note = {"made_by": "tests/golden/make_golden.py", "arithmetic": "float64, rounded to float32"}

    point_weights = read_weights(
        options.weights, ["superpoint.safetensors", "superpoint_narrow.npz"])
    glue_weights = read_weights(
        options.weights, ["superglue.safetensors", "superglue_shallow.npz"])

    for width, height, seed in ((120, 88, 3), (101, 67, 5)):
        result = superpoint(point_weights, synthetic_image(width, height, seed), 0.005)
        print(f"superpoint {width}x{height}: {len(result['scores'])} keypoints")
        path = os.path.join(options.out, f"golden_superpoint_{width}x{height}.safetensors")
        write_safetensors(path, result, {**note, "seed": str(seed), "threshold": "0.005"})

    image0 = synthetic_image(200, 152, 11)
    image1 = warp_affine(image0, [[1.02, -0.05, 9.0], [0.04, 0.98, 3.0]])
    result = superglue(glue_weights, best_features(point_weights, image0, 61),
                       best_features(point_weights, image1, 47), 0.2, steps=(0, 1))
    print(f"superglue open: {(result['matches0'] >= 0).sum()} matches")
    write_safetensors(os.path.join(options.out, "golden_superglue_open.safetensors"), result,
                      {**note, "threshold": "0.2"})

    width = 32
    tiny = random_superglue(7, width, [16, 24], 3)
    write_safetensors(os.path.join(options.out, "superglue_tiny_weights.safetensors"), tiny, note)
    rng = np.random.default_rng(8)
    for count0, count1 in ((13, 22), (1, 3)):
        result = superglue(tiny, random_features(rng, count0, width, (320, 240)),
                           random_features(rng, count1, width, (200, 260)), 0.05,
                           steps=(0, 1, 2))
        print(f"superglue tiny {count0}x{count1}: {(result['matches0'] >= 0).sum()} matches")
        name = f"golden_superglue_tiny_{count0}x{count1}.safetensors"
        write_safetensors(os.path.join(options.out, name), result, {**note, "threshold": "0.05"})
    return 0


if __name__ == "__main__":
    sys.exit(main())
