#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "affine.h"
#include "gluevo/nn/tensor.h"
#include "gluevo/nn/weights.h"

namespace gluevo::nn {

/// An ALIKED's weights in double, reduced by what is exact: batch normalisation is part of the
/// convolution before it (of the sampled values, in a deformable one), the bias of a block's
/// shortcut part of its second convolution, the three equal channels of a gray image are one.
struct AlikedWeights {
  /// A 3x3 convolution as an affine map: column in * 9 + 3 ky + kx.
  using Convolution = Affine;
  struct Block {
    Convolution conv1, conv2;
    /// Of blocks 3 and 4, which are deformable; 18 rows, dy and dx of each tap in turn.
    Convolution offsets1, offsets2;
    /// 1x1, of blocks 2 to 4; without bias.
    Affine downsample;
  };

  std::array<int64_t, 4> widths = {};  ///< Channels after each block.
  int64_t size = 0;                    ///< Of descriptors, a multiple of 64.
  int64_t samples = 0;                 ///< Deformable positions of a descriptor.
  std::array<Block, 4> blocks;
  std::array<Affine, 4> projections;   ///< 1x1, of each block's output to a quarter of the size.
  std::array<Affine, 4> score_groups;  ///< The score head's first layer, split by those quarters.
  std::vector<Tensor<float>> score_layers;  ///< Its others: [out x in x 3 x 3].
  Convolution offsets_hidden;  ///< Of the descriptor head, over a 3x3 patch of features.
  Affine offsets_out;          ///< All dx, then all dy.
  Affine sample_features;
  Affine aggregation;  ///< Column sample * size + channel.
};

/// Throws Error naming the file and the tensor for weights that are not an ALIKED's.
AlikedWeights ReadAlikedWeights(const Weights& weights);

}  // namespace gluevo::nn
