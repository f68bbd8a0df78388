#include "aliked_weights.h"

#include <cmath>
#include <string>

namespace gluevo::nn {
namespace {

constexpr int64_t kTaps = 9;
constexpr int64_t kOffsets = 2 * kTaps;

int64_t Outputs(const Weights& weights, const std::string& name) {
  const Shape& shape = weights.Get(name).shape();
  const int64_t out = shape.rank() > 0 ? shape[0] : 0;
  if (out < 1) {
    throw Error(weights.source + ": " + name + " has shape " + shape.ToString() +
                ", expected the weights of a convolution");
  }
  return out;
}

// [out x in x side x side], and a bias where it has one.
Affine ReadConvolution(const Weights& weights, const std::string& name, int64_t out, int64_t in,
                       int64_t side, bool bias) {
  const Tensor<float>& weight = weights.Get(name + ".weight", Shape{out, in, side, side});
  Affine affine;
  affine.weight = weight.view().Reshaped({out, in * side * side}).Matrix().cast<double>();
  affine.bias = Eigen::VectorXd::Zero(out);
  if (bias) {
    affine.bias = weights.Get(name + ".bias", Shape{out}).view().Vector().cast<double>();
  }
  return affine;
}

// A 3x3 convolution without bias and the batch normalisation behind it (Ioffe and Szegedy 2015).
Affine ReadNormed(const Weights& weights, const std::string& name, const std::string& norm,
                  int64_t out, int64_t in) {
  constexpr double kEpsilon = 1e-5;
  Affine affine = ReadConvolution(weights, name, out, in, 3, false);
  const auto vector = [&](const char* part) -> Eigen::VectorXd {
    return weights.Get(norm + part, Shape{out}).view().Vector().cast<double>();
  };
  const Eigen::VectorXd variance = vector(".running_var");
  if ((variance.array() < 0.0).any()) {
    throw Error(weights.source + ": tensor " + Quoted(norm + ".running_var") +
                " holds a negative variance");
  }
  const Eigen::VectorXd gain = vector(".weight").array() / (variance.array() + kEpsilon).sqrt();
  affine.weight = gain.asDiagonal() * affine.weight;
  affine.bias = vector(".bias") - gain.cwiseProduct(vector(".running_mean"));
  return affine;
}

AlikedWeights::Block ReadBlock(const Weights& weights, int index, int64_t in, int64_t out) {
  const std::string block = "block" + std::to_string(index + 1) + ".";
  const bool deformable = index >= 2;
  const auto read = [&](const std::string& number, int64_t inputs) {
    return ReadNormed(weights, block + "conv" + number + (deformable ? ".regular_conv" : ""),
                      block + "bn" + number, out, inputs);
  };
  AlikedWeights::Block result;
  result.conv1 = read("1", in);
  result.conv2 = read("2", out);
  if (index >= 1) {
    result.downsample = ReadConvolution(weights, block + "downsample", out, in, 1, true);
    result.conv2.bias += result.downsample.bias;
    result.downsample.bias.setZero();
  }
  if (deformable) {
    result.offsets1 = ReadConvolution(weights, block + "conv1.offset_conv", kOffsets, in, 3, true);
    result.offsets2 = ReadConvolution(weights, block + "conv2.offset_conv", kOffsets, out, 3, true);
  }
  return result;
}

// The three channels of a gray image are equal: one channel of the sum of their weights.
void FoldColours(Affine& convolution) {
  const Affine::Matrix colours = convolution.weight;
  convolution.weight =
      colours.leftCols(kTaps) + colours.middleCols(kTaps, kTaps) + colours.rightCols(kTaps);
}

void ReadScoreHead(const Weights& weights, AlikedWeights& result) {
  const int64_t hidden = Outputs(weights, "score_head.0.weight");
  const Affine first = ReadConvolution(weights, "score_head.0", hidden, result.size, 1, false);
  const int64_t group = result.size / 4;
  for (int i = 0; i < 4; ++i) {
    result.score_groups[static_cast<std::size_t>(i)] = {first.weight.middleCols(i * group, group),
                                                        first.bias};
  }
  int64_t in = hidden;
  for (const char* const name :
       {"score_head.2.weight", "score_head.4.weight", "score_head.6.weight"}) {
    const int64_t out = Outputs(weights, name);
    result.score_layers.push_back(weights.Get(name, Shape{out, in, 3, 3}));
    in = out;
  }
  if (hidden > 16 || in != 1) {
    throw Error(weights.source + ": the score head has " + std::to_string(hidden) +
                " channels and " + std::to_string(in) + " outputs, expected at most 16 and one");
  }
}

void ReadDescriptorHead(const Weights& weights, AlikedWeights& result) {
  const int64_t size = result.size;
  const Tensor<float>& aggregation = weights.Get("desc_head.agg_weights");
  result.samples = aggregation.shape().rank() > 0 ? aggregation.extent(0) : 0;
  const int64_t samples = result.samples;
  weights.Get("desc_head.agg_weights", Shape{samples, size, size});
  if (samples < 1) {
    throw Error(weights.source + ": desc_head.agg_weights is empty");
  }
  // Published: [sample][input][output].
  result.aggregation.weight =
      aggregation.view().Reshaped({samples * size, size}).Matrix().transpose().cast<double>();
  result.aggregation.bias = Eigen::VectorXd::Zero(size);
  const std::string head = "desc_head.";
  result.offsets_hidden =
      ReadConvolution(weights, head + "offset_conv.0", 2 * samples, size, 3, true);
  result.offsets_out =
      ReadConvolution(weights, head + "offset_conv.2", 2 * samples, 2 * samples, 1, true);
  result.sample_features = ReadConvolution(weights, head + "sf_conv", size, size, 1, false);
}

}  // namespace

AlikedWeights ReadAlikedWeights(const Weights& weights) {
  if (!weights.Has("desc_head.agg_weights")) {
    throw Error(weights.source + ": not the weights of an ALIKED: no tensor desc_head.agg_weights" +
                (weights.Has("conv1a.weight")      ? " (these are a SuperPoint's)"
                 : weights.Has("posenc.Wr.weight") ? " (these are a LightGlue's)"
                                                   : " (gluevo-weights converts other forms)"));
  }
  AlikedWeights result;
  constexpr int64_t kColours = 3;
  int64_t in = kColours;
  for (int i = 0; i < 4; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const std::string conv1 = "block" + std::to_string(i + 1) + ".conv1.";
    result.widths[at] = Outputs(weights, conv1 + (i >= 2 ? "regular_conv.weight" : "weight"));
    result.blocks[at] = ReadBlock(weights, i, in, result.widths[at]);
    in = result.widths[at];
  }
  FoldColours(result.blocks[0].conv1);
  const int64_t group = Outputs(weights, "conv1.weight");
  result.size = 4 * group;
  if (group % 16 != 0) {
    throw Error(weights.source + ": descriptors of " + std::to_string(result.size) +
                " values, expected a multiple of 64");
  }
  for (int i = 0; i < 4; ++i) {
    const auto at = static_cast<std::size_t>(i);
    result.projections[at] = ReadConvolution(weights, "conv" + std::to_string(i + 1), group,
                                             result.widths[at], 1, false);
  }
  ReadScoreHead(weights, result);
  ReadDescriptorHead(weights, result);
  return result;
}

}  // namespace gluevo::nn
