#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gluevo/nn/tensor.h"
#include "lightglue_weights.h"
#include "packed_linear.h"

namespace gluevo::nn {

/// The weights of LightGlueNetwork, packed as its products read them. Heads of queries, keys and
/// values have the same padded size: two halves of whole blocks. Those of queries and keys of
/// self-attention hold the first members of the pairs that rotary encoding turns, then the second.
struct LightGlueLayers {
  struct Mlp {
    Linear<float> in;  ///< Of token and attention's output.
    Tensor<float> gain;
    Tensor<float> shift;
    Linear<float> out;
  };
  struct Layer {
    Linear<float> q, k, v;
    Mlp self_mlp;
    Linear<float> qk, cross_v;
    Mlp cross_mlp;
    Linear<float> decisions;  ///< Logits: column 0 matchability, column 1 confidence.
    Linear<float> final_projection;
  };

  explicit LightGlueLayers(const LightGlueWeights& weights);
  LightGlueLayers(LightGlueLayers&&) noexcept = default;

  int64_t head_blocks() const { return 2 * half_blocks; }
  int64_t heads_size() const { return heads * head_blocks() * kernels::kBlock; }

  int64_t descriptor_size;
  int64_t size;
  int64_t heads;
  int64_t half_blocks;  ///< Of half a head.
  bool has_confidence;
  Eigen::Matrix<double, Eigen::Dynamic, 2> position;
  std::optional<Linear<float>> input_projection;
  std::vector<Layer> layers;

 private:
  Tensor<float> storage_;
};

}  // namespace gluevo::nn
