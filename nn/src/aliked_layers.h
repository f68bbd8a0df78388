#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "aliked_weights.h"
#include "gluevo/nn/tensor.h"
#include "kernels/kernels.h"
#include "packed_linear.h"

namespace gluevo::nn {

/// The weights of AlikedNetwork, packed as its kernels read them.
struct AlikedLayers {
  /// A 3x3 convolution, packed for its kernel: Winograd's where the set has one and whole regions
  /// are computed at a time, else the direct one.
  struct Convolution {
    void (*kernel)(const kernels::Conv3x3&) = nullptr;
    Tensor<float> weights;
    Tensor<float> bias;  ///< Whole blocks.
  };
  /// A deformable one as a product of DeformableRows, and of the block's input where a shortcut is
  /// part of it.
  struct Deformable {
    Convolution offsets;
    Linear<float> values;
  };

  AlikedLayers(const AlikedWeights& weights, const kernels::Kernels& kernels);
  AlikedLayers(AlikedLayers&&) noexcept = default;

  std::array<int64_t, 4> widths;
  int64_t size;
  int64_t samples;
  Convolution block1_conv1, block1_conv2, block2_conv1, block2_conv2;
  Linear<float> block2_downsample;
  std::array<std::array<Deformable, 2>, 2> deformable;  ///< Of blocks 3 and 4.
  std::array<Linear<float>, 4> projections;
  std::array<Linear<float>, 4> score_groups;
  int64_t score_channels;  ///< Of the first layer.
  std::vector<Tensor<float>> score_layers;
  Linear<float> offsets_hidden, offsets_out, sample_features, aggregation;

 private:
  Tensor<float> storage_;
};

}  // namespace gluevo::nn
