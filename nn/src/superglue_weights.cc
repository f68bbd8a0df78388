#include "superglue_weights.h"

#include <cmath>
#include <cstdlib>
#include <string>

namespace gluevo::nn {
namespace {

// A batch normalisation that follows the affine map, with its running statistics (Ioffe and
// Szegedy 2015).
void FoldBatchNorm(const Weights& weights, const std::string& name, Affine& affine) {
  constexpr double kEpsilon = 1e-5;
  const Shape shape{affine.bias.size()};
  const auto vector = [&](const char* part) -> Eigen::VectorXd {
    return weights.Get(name + part, shape).view().Vector().cast<double>();
  };
  const Eigen::VectorXd gain =
      vector(".weight").array() / (vector(".running_var").array() + kEpsilon).sqrt();
  affine.weight = gain.asDiagonal() * affine.weight;
  affine.bias = gain.cwiseProduct(affine.bias - vector(".running_mean")) + vector(".bias");
}

SuperGlueWeights::Layer ReadLayer(const Weights& weights, const std::string& prefix, int64_t size,
                                  int64_t heads) {
  const Affine q = ReadAffine(weights, prefix + "attn.proj.0", size);
  const Affine k = ReadAffine(weights, prefix + "attn.proj.1", size);
  const Affine v = ReadAffine(weights, prefix + "attn.proj.2", size);
  const Affine merge = ReadAffine(weights, prefix + "attn.merge", size);
  Affine mlp = ReadAffine(weights, prefix + "mlp.0", 2 * size);
  FoldBatchNorm(weights, prefix + "mlp.1", mlp);

  // Published channels are (dimension, head); here a head's channels lie together.
  const int64_t head_size = size / heads;
  const double scale = 1.0 / std::sqrt(static_cast<double>(head_size));
  std::vector<Eigen::Index> by_head;
  for (int64_t i = 0; i < size; ++i) {
    by_head.push_back(i % head_size * heads + i / head_size);
  }
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(size);
  const auto message_half = mlp.weight.rightCols(size);
  SuperGlueWeights::Layer layer;
  layer.q = {scale * q.weight(by_head, Eigen::all), scale * q.bias(by_head)};
  layer.k = {k.weight(by_head, Eigen::all), none};
  layer.v = {v.weight(by_head, Eigen::all), none};
  layer.mlp_token = {mlp.weight.leftCols(size),
                     mlp.bias + message_half * (merge.weight * v.bias + merge.bias)};
  layer.mlp_attend = {message_half * merge.weight(Eigen::all, by_head),
                      Eigen::VectorXd::Zero(mlp.bias.size())};
  layer.mlp_out = ReadAffine(weights, prefix + "mlp.3", mlp.bias.size());
  return layer;
}

}  // namespace

SuperGlueWeights ReadSuperGlueWeights(const Weights& weights) {
  if (!weights.Has("kenc.encoder.0.weight")) {
    throw Error(weights.source + ": not the weights of a SuperGlue: no tensor " +
                "kenc.encoder.0.weight" +
                (weights.Has("conv1a.weight")      ? " (these are a SuperPoint's)"
                 : weights.Has("posenc.Wr.weight") ? " (these are a LightGlue's, which is another "
                                                     "network)"
                                                   : " (gluevo-weights converts other forms)"));
  }
  SuperGlueWeights result;
  // Keypoint encoder: affine maps with batch normalisation and ReLU between them; as modules of one
  // list they are numbered 0, 3, 6, ...
  int64_t channels = 3;
  for (int module = 0; weights.Has("kenc.encoder." + std::to_string(module) + ".weight");
       module += 3) {
    const std::string prefix = "kenc.encoder.";
    Affine affine = ReadAffine(weights, prefix + std::to_string(module), channels);
    channels = affine.bias.size();
    if (weights.Has(prefix + std::to_string(module + 1) + ".weight")) {
      FoldBatchNorm(weights, prefix + std::to_string(module + 1), affine);
    }
    result.encoder.push_back(affine);
  }
  result.size = channels;

  result.heads = 4;
  if (weights.metadata.contains("heads")) {
    result.heads = std::atoi(weights.metadata.at("heads").c_str());
  }
  if (result.heads < 1 || result.size % result.heads != 0) {
    throw Error(weights.source + ": " + std::to_string(result.heads) +
                " heads do not divide the descriptor size " + std::to_string(result.size));
  }
  for (int i = 0;; ++i) {
    const std::string prefix = "gnn.layers." + std::to_string(i) + ".";
    if (!weights.Has(prefix + "attn.merge.weight")) {
      break;
    }
    result.layers.push_back(ReadLayer(weights, prefix, result.size, result.heads));
  }
  if (result.layers.empty()) {
    throw Error(weights.source + ": a SuperGlue without layers: no tensor " +
                "gnn.layers.0.attn.merge.weight");
  }

  result.final_projection = ReadAffine(weights, "final_proj", result.size);
  const double root = std::pow(static_cast<double>(result.size), -0.25);
  result.final_projection.weight *= root;
  result.final_projection.bias *= root;
  const Tensor<float>& bin_score = weights.Get("bin_score");
  CheckShape({bin_score.size()}, {1}, weights.source + ": bin_score");
  result.dustbin_score = bin_score[0];
  return result;
}

}  // namespace gluevo::nn
