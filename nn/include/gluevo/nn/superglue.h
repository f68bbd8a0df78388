#pragma once

#include <cstdint>
#include <vector>

#include "gluevo/nn/features.h"
#include "gluevo/nn/isa.h"
#include "gluevo/nn/tensor.h"
#include "gluevo/nn/weights.h"
#include "gluevo/nn/workspace.h"

namespace gluevo::nn {

namespace kernels {
struct Kernels;
}

struct SuperGlueOptions {
  /// Matches have a confidence above this, 0 to 1.
  float match_threshold = 0.2F;
  int sinkhorn_iterations = 100;

  /// Throws Error naming the field that is out of range.
  void Validate() const;
};

/// SuperGlue (Sarlin et al. 2020): matches two sets of keypoints by an attentional graph network
/// and optimal transport. Widths and number of layers are those of the weights; layers alternate
/// self- and cross-attention. The number of heads is the metadata's "heads", else 4.
class SuperGlue {
 public:
  /// Throws Error naming the file and the tensor for weights that are not a SuperGlue's.
  explicit SuperGlue(const Weights& weights, Isa isa = ChooseIsa());

  /// Size of the descriptors it matches, 256 in all published forms.
  int descriptor_size() const { return static_cast<int>(size_); }
  int layers() const { return static_cast<int>(layers_.size()); }

  /// The logarithm of the assignment matrix [(n0 + 1) x (n1 + 1)], dustbins last: a row sums to 1
  /// (the dustbin's to n1) where Sinkhorn has converged. Lives in the workspace until its next use.
  /// Throws Error for descriptors of another size; needs at least one keypoint in each set.
  TensorView<float> LogAssignment(const Features& features0, const Features& features1,
                                  const SuperGlueOptions& options, Workspace& workspace) const;

  /// Mutual best pairs of the assignment above the threshold; none where a set is empty.
  void Match(const Features& features0, const Features& features1, const SuperGlueOptions& options,
             Workspace& workspace, Matches& matches) const;

 private:
  // A product with a packed matrix and a bias.
  struct Linear {
    int64_t in = 0;
    int64_t out = 0;
    Tensor<float> weights;
    Tensor<float> bias;
  };
  struct Layer {
    Linear qkv;    // Rows of q, k, v; of each, head after head.
    Linear mlp_a;  // Of the token and of the attention's output, side by side.
    Linear mlp_b;
  };

  struct Scratch;
  // What is multiplied by a Linear: rows of a0, or of a0 and a1 side by side.
  struct MatMulOperands {
    const float* a0 = nullptr;
    const float* a1 = nullptr;
    int64_t k1 = 0;  // Columns of a1.
    bool relu = false;
    const float* residual = nullptr;
    float* c = nullptr;
    int64_t rows = 0;
  };

  void Multiply(const Linear& linear, const MatMulOperands& operands, ThreadPool& pool) const;
  // Rows [n0 + n1][size_] after the last layer, image 0's first.
  TensorView<float> Tokens(const Features& features0, const Features& features1,
                           Workspace& workspace) const;
  void RunLayer(const Layer& layer, bool cross, int64_t n0, TensorView<float> tokens,
                const Scratch& scratch, ThreadPool& pool) const;

  const kernels::Kernels* kernels_;
  int64_t size_ = 0;
  int64_t heads_ = 4;
  std::vector<Linear> encoder_;
  std::vector<Layer> layers_;
  Linear final_;  // With the fourth root of 1 / size_, so that products are scores.
  float dustbin_score_ = 0.0F;
};

}  // namespace gluevo::nn
