#include "lightglue_weights.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace gluevo::nn {
namespace {

Affine ReadSquare(const Weights& weights, const std::string& name, int64_t out, int64_t in) {
  weights.Get(name + ".weight", Shape{out, in});
  return ReadAffine(weights, name, in);
}

// The MLP behind an attention whose output passes through `out_projection` and comes with the bias
// of its values.
LightGlueWeights::Mlp ReadMlp(const Weights& weights, const std::string& block,
                              const Affine& out_projection, const Eigen::VectorXd& value_bias) {
  const int64_t size = out_projection.bias.size();
  const Affine in = ReadSquare(weights, block + "ffn.0", 2 * size, 2 * size);
  const auto message_half = in.weight.rightCols(size);
  LightGlueWeights::Mlp mlp;
  mlp.token = {in.weight.leftCols(size),
               in.bias + message_half * (out_projection.weight * value_bias + out_projection.bias)};
  mlp.message = {message_half * out_projection.weight, Eigen::VectorXd::Zero(2 * size)};
  const Shape shape{2 * size};
  mlp.gain = weights.Get(block + "ffn.1.weight", shape).view().Vector().cast<double>();
  mlp.shift = weights.Get(block + "ffn.1.bias", shape).view().Vector().cast<double>();
  mlp.out = ReadSquare(weights, block + "ffn.3", size, 2 * size);
  return mlp;
}

LightGlueWeights::Layer ReadLayer(const Weights& weights, int index, int64_t size, int64_t heads) {
  const std::string number = std::to_string(index);
  const std::string self = "transformers." + number + ".self_attn.";
  const std::string cross = "transformers." + number + ".cross_attn.";
  const auto head_size = static_cast<double>(size / heads);
  LightGlueWeights::Layer layer;

  // Published rows are (head, channel, which of the three).
  const Affine qkv = ReadSquare(weights, self + "Wqkv", 3 * size, size);
  const auto part = [&](int64_t which, double scale) -> Affine {
    const auto rows = Eigen::seqN(which, size, 3);
    return {scale * qkv.weight(rows, Eigen::all), scale * qkv.bias(rows)};
  };
  layer.q = part(0, 1.0 / std::sqrt(head_size));
  layer.k = part(1, 1.0);
  layer.v = part(2, 1.0);
  layer.self_mlp =
      ReadMlp(weights, self, ReadSquare(weights, self + "out_proj", size, size), layer.v.bias);
  layer.v.bias.setZero();

  const double root = std::pow(head_size, -0.25);
  layer.qk = ReadSquare(weights, cross + "to_qk", size, size);
  layer.qk.weight *= root;
  layer.qk.bias *= root;
  layer.cross_v = ReadSquare(weights, cross + "to_v", size, size);
  layer.cross_mlp = ReadMlp(weights, cross, ReadSquare(weights, cross + "to_out", size, size),
                            layer.cross_v.bias);
  layer.cross_v.bias.setZero();

  const std::string assignment = "log_assignment." + number + ".";
  const double final_root = std::pow(static_cast<double>(size), -0.25);
  layer.final_projection = ReadSquare(weights, assignment + "final_proj", size, size);
  layer.final_projection.weight *= final_root;
  layer.final_projection.bias *= final_root;
  layer.matchability = ReadSquare(weights, assignment + "matchability", 1, size);
  const std::string confidence = "token_confidence." + number + ".token.0";
  if (weights.Has(confidence + ".weight")) {
    layer.confidence = ReadSquare(weights, confidence, 1, size);
  }
  return layer;
}

std::string WhatElse(const Weights& weights) {
  if (weights.Has("kenc.encoder.0.weight")) {
    return " (these are a SuperGlue's)";
  }
  if (weights.Has("conv1a.weight")) {
    return " (these are a SuperPoint's)";
  }
  return weights.Has("desc_head.agg_weights") ? " (these are an ALIKED's)"
                                              : " (gluevo-weights converts other forms)";
}

// Size and heads, of the position encoding and the first layer.
void ReadSizes(const Weights& weights, LightGlueWeights& result) {
  const Tensor<float>& position = weights.Get("posenc.Wr.weight");
  if (position.shape().rank() != 2 || position.extent(0) < 1 || position.extent(1) != 2) {
    throw Error(weights.source + ": posenc.Wr.weight has shape " + position.shape().ToString() +
                ", expected [angles x 2]: only positions are encoded here, no scale nor "
                "orientation of keypoints");
  }
  result.position = position.view().Matrix().cast<double>();
  const Tensor<float>& qk = weights.Get("transformers.0.cross_attn.to_qk.weight");
  result.size = qk.shape().rank() > 0 ? qk.extent(0) : 0;
  const int64_t head_size = 2 * position.extent(0);
  if (result.size < 1 || result.size % head_size != 0) {
    throw Error(weights.source + ": tokens of " + std::to_string(result.size) +
                " values do not divide into heads of " + std::to_string(head_size) +
                ", two for each of the angles of posenc.Wr.weight");
  }
  result.heads = result.size / head_size;
  result.descriptor_size = result.size;
  if (weights.Has("input_proj.weight")) {
    const Tensor<float>& projection = weights.Get("input_proj.weight");
    result.descriptor_size = projection.shape().rank() == 2 ? projection.extent(1) : 0;
    if (result.descriptor_size < 1) {
      throw Error(weights.source + ": input_proj.weight has shape " +
                  projection.shape().ToString() + ", expected [" + std::to_string(result.size) +
                  " x size of descriptors]");
    }
    result.input_projection =
        ReadSquare(weights, "input_proj", result.size, result.descriptor_size);
  }
}

}  // namespace

bool LightGlueWeights::has_confidence() const {
  return std::all_of(layers.begin(), layers.end() - 1,
                     [](const Layer& layer) { return layer.confidence.has_value(); });
}

LightGlueWeights ReadLightGlueWeights(const Weights& weights) {
  for (const char* const name : {"posenc.Wr.weight", "transformers.0.cross_attn.to_qk.weight"}) {
    if (!weights.Has(name)) {
      throw Error(weights.source + ": not the weights of a LightGlue: no tensor " + name +
                  WhatElse(weights));
    }
  }
  LightGlueWeights result;
  ReadSizes(weights, result);
  for (int i = 0; weights.Has("transformers." + std::to_string(i) + ".cross_attn.to_qk.weight");
       ++i) {
    result.layers.push_back(ReadLayer(weights, i, result.size, result.heads));
  }
  return result;
}

}  // namespace gluevo::nn
