#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "affine.h"
#include "gluevo/nn/weights.h"

namespace gluevo::nn {

/// A LightGlue's weights in double, reduced by what is exact: 1/sqrt(d) of attention is part of q
/// (of both sides of cross-attention d^(-1/4)), that of the assignment part of the final
/// projection; out_proj and to_out, which nothing but a sum separates from the MLP behind them, are
/// part of it, and so is the bias of v, since attention's weights sum to 1. (The bias of k stays:
/// rotary encoding comes after it, and the softmax of cross-attention and assignment runs both
/// ways.)
struct LightGlueWeights {
  /// x + out(gelu(norm(token x + message m + bias))).
  struct Mlp {
    Affine token;          ///< The half of the token, with the bias of both.
    Affine message;        ///< The half of attention's output, columns head after head; no bias.
    Eigen::VectorXd gain;  ///< Of the layer normalisation.
    Eigen::VectorXd shift;
    Affine out;
  };
  struct Layer {
    Affine q, k, v;  ///< Rows head after head; v without bias.
    Mlp self_mlp;
    Affine qk, cross_v;  ///< Of cross-attention, where one projection is query and key.
    Mlp cross_mlp;
    Affine final_projection;  ///< With size^(-1/4), so that products of two are scores.
    /// Logit of "has a match", and of "its match will not change any more", which the last layer
    /// lacks: rows 0 and 1.
    Affine matchability;
    std::optional<Affine> confidence;
  };

  int64_t descriptor_size = 0;
  int64_t size = 0;  ///< Of tokens.
  int64_t heads = 0;
  std::optional<Affine> input_projection;  ///< Where the two sizes differ.
  /// Angles of a position [size / heads / 2 x 2], the same for all heads.
  Eigen::Matrix<double, Eigen::Dynamic, 2> position;
  std::vector<Layer> layers;

  /// All layers but the last can tell how sure they are.
  bool has_confidence() const;
};

/// Throws Error naming the file and the tensor for weights that are not a LightGlue's.
LightGlueWeights ReadLightGlueWeights(const Weights& weights);

}  // namespace gluevo::nn
