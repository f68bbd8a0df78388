#pragma once

#include <cstdint>
#include <vector>

#include "affine.h"
#include "gluevo/nn/weights.h"

namespace gluevo::nn {

/// A SuperGlue's weights in double, reduced by what is exact: batch normalisation is part of the
/// convolution before it, 1/sqrt(d) part of q, `merge` part of the MLP; the bias of k, which the
/// softmax cancels, is gone, and that of v, which passes through attention, is part of the next.
struct SuperGlueWeights {
  struct Layer {
    Affine q, k, v;     ///< Rows head after head; k and v without bias.
    Affine mlp_token;   ///< First matrix of the MLP, the token's half, with the bias of both.
    Affine mlp_attend;  ///< The half of attention's output, columns head after head; no bias.
    Affine mlp_out;
  };

  int64_t size = 0;  ///< Of descriptors.
  int64_t heads = 0;
  std::vector<Affine> encoder;  ///< With ReLU between them.
  std::vector<Layer> layers;
  Affine final_projection;  ///< With size^(-1/4), so that products of two are scores.
  float dustbin_score = 0.0F;
};

/// Throws Error naming the file and the tensor for weights that are not a SuperGlue's.
SuperGlueWeights ReadSuperGlueWeights(const Weights& weights);

}  // namespace gluevo::nn
