#pragma once

#include <string>
#include <vector>

#include "gluevo/nn/superpoint.h"
#include "kernels/kernels.h"
#include "map_regions.h"

namespace gluevo::nn {

/// A convolution of SuperPoint with what follows it.
struct SuperPoint::Convolution {
  /// Reads NAME.weight [out][in_channels][size][size], NAME.bias and, where they are there,
  /// NAME.scale and NAME.shift; throws Error naming the file and the tensor.
  Convolution(const Weights& file, const std::string& name, int64_t kernel_size,
              int64_t in_channels_in, const kernels::Kernels& kernels);

  /// All of `in`, as the task of one thread.
  kernels::Conv3x3 Of(const kernels::BlockedMap& in, const kernels::BlockedMap& out,
                      const Buffers& buffers, int worker) const;

  int64_t in_channels = 0;
  int64_t out_channels = 0;
  bool pool = false;
  /// The kernel of a 3x3 convolution, which decides how its weights are packed.
  void (*kernel)(const kernels::Conv3x3&) = nullptr;
  Tensor<float> weights;
  Tensor<float> bias;  ///< This and the next two padded to whole blocks.
  Tensor<float> scale;
  Tensor<float> shift;
};

/// A 3x3 convolution of the trunk's output and a 1x1 convolution of that.
struct SuperPoint::Head {
  Convolution hidden;
  Convolution output;
};

struct SuperPoint::Layers {
  std::vector<Convolution> trunk;  ///< 1a to 4b.
  Head detector;                   ///< Pa and Pb.
  Head descriptor;                 ///< Da and Db.
};

/// What the layers of one call share. The maps between 3x3 layers take turns in two buffers.
struct SuperPoint::Buffers {
  TensorView<float> maps;     ///< [2][floats of the largest map]
  TensorView<float> scratch;  ///< Of each thread, for the kernels.

  /// A map for the output of a layer that reads `in`: in the other buffer, with its halo cleared.
  kernels::BlockedMap Output(const kernels::BlockedMap& in, int64_t channels, int64_t height,
                             int64_t width) const;
};

}  // namespace gluevo::nn
