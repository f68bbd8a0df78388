#pragma once

#include <cstdint>
#include <vector>

#include "gluevo/nn/tensor.h"
#include "kernels/kernels.h"
#include "superglue_weights.h"

namespace gluevo::nn {

/// Channels in whole blocks of elements.
template <typename Element>
int64_t PaddedChannels(int64_t channels) {
  return kernels::ElementBlocks<Element>(channels) * kernels::kBlock *
         kernels::kChannelsPer<Element>;
}

/// A product with packed weights; the left operand may have a second part.
template <typename Operand>
struct Linear {
  int64_t blocks0 = 0;
  int64_t blocks1 = 0;
  int64_t columns = 0;  ///< Whole blocks.
  const Operand* weights = nullptr;
  Tensor<float> bias;
};

/// The weights of GraphNetwork, packed as its products read them. Weights that are used one after
/// the other lie so in memory: what a product fetches ahead beyond its last columns is the
/// beginning of the next product's.
template <typename Element>
struct GraphNetworkWeights {
  struct Layer {
    Linear<Element> q, k, v, mlp_in, mlp_out;
  };

  explicit GraphNetworkWeights(const SuperGlueWeights& weights);
  GraphNetworkWeights(GraphNetworkWeights&&) noexcept = default;

  int64_t size;  ///< Channels of a token.
  int64_t heads;
  int64_t head_size;        ///< Channels of a head, whole blocks of elements.
  int64_t hidden_size = 0;  ///< Widest of the layers' hidden ones, whole blocks of elements.
  int64_t widest = 0;       ///< Of the encoder, whole blocks.
  std::vector<Linear<float>> encoder;
  std::vector<Layer> layers;
  Linear<Element> final_projection;

 private:
  Tensor<float> encoder_storage_;
  Tensor<Element> storage_;
};

extern template struct GraphNetworkWeights<float>;
extern template struct GraphNetworkWeights<kernels::Bf16Pair>;

}  // namespace gluevo::nn
