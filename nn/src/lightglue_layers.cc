#include "lightglue_layers.h"

#include "kernels/kernels.h"

namespace gluevo::nn {
namespace {

using kernels::kBlock;

// Rows (head, 2 j + i) moved to head * padded + i * padded / 2 + j: the pairs of rotary encoding
// half a head apart.
Affine SplitPairs(const Affine& affine, int64_t heads, int64_t padded) {
  const int64_t head_size = affine.bias.size() / heads;
  Affine result;
  result.weight.setZero(heads * padded, affine.weight.cols());
  result.bias.setZero(heads * padded);
  for (int64_t row = 0; row < affine.bias.size(); ++row) {
    const int64_t channel = row % head_size;
    const int64_t to = row / head_size * padded + channel % 2 * (padded / 2) + channel / 2;
    result.weight.row(to) = affine.weight.row(row);
    result.bias[to] = affine.bias[row];
  }
  return result;
}

Tensor<float> Padded(const Eigen::VectorXd& values) {
  Tensor<float> padded({PaddedChannels<float>(values.size())});
  padded.view().Vector().head(values.size()) = values.cast<float>();
  return padded;
}

// Both halves side by side, each in whole blocks, heads as far apart as attention writes them.
Affine JoinHalves(const LightGlueWeights::Mlp& mlp, int64_t heads, int64_t padded) {
  const int64_t size = mlp.token.weight.cols();
  const int64_t token_size = PaddedChannels<float>(size);
  const int64_t head_size = size / heads;
  Affine joined;
  joined.bias = mlp.token.bias;
  joined.weight.setZero(joined.bias.size(), token_size + heads * padded);
  joined.weight.leftCols(size) = mlp.token.weight;
  for (int64_t head = 0; head < heads; ++head) {
    joined.weight.middleCols(token_size + head * padded, head_size) =
        mlp.message.weight.middleCols(head * head_size, head_size);
  }
  return joined;
}

Affine JoinDecisions(const LightGlueWeights::Layer& layer) {
  Affine joined;
  joined.weight.setZero(2, layer.matchability.weight.cols());
  joined.bias.setZero(2);
  joined.weight.row(0) = layer.matchability.weight.row(0);
  joined.bias[0] = layer.matchability.bias[0];
  if (layer.confidence) {
    joined.weight.row(1) = layer.confidence->weight.row(0);
    joined.bias[1] = layer.confidence->bias[0];
  }
  return joined;
}

int64_t Room(const LightGlueWeights& weights, int64_t token_size, int64_t heads_size) {
  const auto room = kernels::PackedMatrixSize<float>;
  const int64_t hidden = PaddedChannels<float>(2 * weights.size);
  const int64_t mlp = room(hidden, token_size + heads_size) + room(token_size, 2 * weights.size);
  const int64_t layer = 5 * room(heads_size, weights.size) + 2 * mlp + room(kBlock, weights.size) +
                        room(token_size, weights.size);
  return room(token_size, weights.descriptor_size) +
         static_cast<int64_t>(weights.layers.size()) * layer;
}

}  // namespace

LightGlueLayers::LightGlueLayers(const LightGlueWeights& weights)
    : descriptor_size(weights.descriptor_size),
      size(weights.size),
      heads(weights.heads),
      half_blocks(kernels::BlocksOf(weights.size / weights.heads / 2)),
      has_confidence(weights.has_confidence()),
      position(weights.position) {
  const int64_t token_size = PaddedChannels<float>(size);
  const int64_t padded_head = head_blocks() * kBlock;
  storage_ = Tensor<float>({Room(weights, token_size, heads_size())});
  Packer<float> packer(storage_);
  const auto pack_pairs = [&](const Affine& affine) {
    return packer.Pack(SplitPairs(affine, heads, padded_head), heads_size());
  };
  const auto pack_heads = [&](const Affine& affine) {
    return packer.Pack(PadHeads(affine, heads, padded_head), heads_size());
  };
  const auto pack_mlp = [&](const LightGlueWeights::Mlp& from) {
    Mlp mlp;
    mlp.in = packer.Pack(JoinHalves(from, heads, padded_head),
                         PaddedChannels<float>(from.token.bias.size()));
    mlp.in.blocks0 = token_size / kBlock;
    mlp.in.blocks1 = heads_size() / kBlock;
    mlp.gain = Padded(from.gain);
    mlp.shift = Padded(from.shift);
    mlp.out = packer.Pack(from.out, token_size);
    return mlp;
  };
  if (weights.input_projection) {
    input_projection = packer.Pack(*weights.input_projection, token_size);
  }
  layers.reserve(weights.layers.size());
  for (const LightGlueWeights::Layer& from : weights.layers) {
    Layer& layer = layers.emplace_back();
    layer.q = pack_pairs(from.q);
    layer.k = pack_pairs(from.k);
    layer.v = pack_heads(from.v);
    layer.self_mlp = pack_mlp(from.self_mlp);
    layer.qk = pack_heads(from.qk);
    layer.cross_v = pack_heads(from.cross_v);
    layer.cross_mlp = pack_mlp(from.cross_mlp);
    layer.decisions = packer.Pack(JoinDecisions(from), kBlock);
    layer.final_projection = packer.Pack(from.final_projection, token_size);
  }
}

}  // namespace gluevo::nn
