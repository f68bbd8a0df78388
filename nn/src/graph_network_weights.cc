#include "graph_network_weights.h"

#include <algorithm>

namespace gluevo::nn {

template <typename Element>
GraphNetworkWeights<Element>::GraphNetworkWeights(const SuperGlueWeights& weights)
    : size(weights.size),
      heads(weights.heads),
      head_size(PaddedChannels<Element>(weights.size / weights.heads)) {
  const auto room_for = [](const Affine& affine) {
    return kernels::PackedMatrixSize<float>(PaddedChannels<float>(affine.bias.size()),
                                            affine.weight.cols());
  };
  int64_t encoder_room = 0;
  for (const Affine& affine : weights.encoder) {
    encoder_room += room_for(affine);
  }
  encoder_storage_ = Tensor<float>({encoder_room});
  Packer<float> encoder_packer(encoder_storage_);
  for (const Affine& affine : weights.encoder) {
    encoder.push_back(encoder_packer.Pack(affine, PaddedChannels<float>(affine.bias.size())));
    widest = std::max(widest, encoder.back().columns);
  }

  // Token and attention side by side, each in whole blocks of elements.
  const int64_t token_size = PaddedChannels<Element>(size);
  const int64_t heads_size = heads * head_size;
  const auto room = kernels::PackedMatrixSize<Element>;
  int64_t layers_room = room(PaddedChannels<float>(size), size);
  for (const SuperGlueWeights::Layer& layer : weights.layers) {
    const int64_t hidden = PaddedChannels<Element>(layer.mlp_token.bias.size());
    layers_room += 3 * room(heads_size, size) + room(hidden, token_size + heads_size) +
                   room(token_size, layer.mlp_out.weight.cols());
  }
  storage_ = Tensor<Element>({layers_room});
  Packer<Element> packer(storage_);
  for (const SuperGlueWeights::Layer& from : weights.layers) {
    const auto pack_heads = [&](const Affine& affine) {
      return packer.Pack(PadHeads(affine, heads, head_size), heads_size);
    };
    const int64_t hidden = from.mlp_token.bias.size();
    Affine mlp_in;
    mlp_in.bias = from.mlp_token.bias;
    mlp_in.weight.setZero(hidden, token_size + heads_size);
    mlp_in.weight.leftCols(size) = from.mlp_token.weight;
    const int64_t unpadded = size / heads;
    for (int64_t head = 0; head < heads; ++head) {
      mlp_in.weight.middleCols(token_size + head * head_size, unpadded) =
          from.mlp_attend.weight.middleCols(head * unpadded, unpadded);
    }
    Layer& layer = layers.emplace_back();
    layer.q = pack_heads(from.q);
    layer.k = pack_heads(from.k);
    layer.v = pack_heads(from.v);
    layer.mlp_in = packer.Pack(mlp_in, PaddedChannels<Element>(hidden));
    layer.mlp_in.blocks0 = kernels::ElementBlocks<Element>(size);
    layer.mlp_in.blocks1 = kernels::ElementBlocks<Element>(heads_size);
    layer.mlp_out = packer.Pack(from.mlp_out, token_size);
    hidden_size = std::max(hidden_size, layer.mlp_in.columns);
  }
  final_projection = packer.Pack(weights.final_projection, PaddedChannels<float>(size));
}

template struct GraphNetworkWeights<float>;
template struct GraphNetworkWeights<kernels::Bf16Pair>;

}  // namespace gluevo::nn
