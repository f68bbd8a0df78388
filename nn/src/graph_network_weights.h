#pragma once

#include <cstdint>
#include <vector>

#include "gluevo/nn/tensor.h"
#include "kernels/kernels.h"
#include "packed_linear.h"
#include "superglue_weights.h"

namespace gluevo::nn {

/// The weights of GraphNetwork, packed as its products read them.
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
