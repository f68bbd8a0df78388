#pragma once

#include <cstdint>
#include <memory>

#include "gluevo/nn/features.h"
#include "gluevo/nn/isa.h"
#include "gluevo/nn/precision.h"
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
  explicit SuperGlue(const Weights& weights, Precision precision = Precision::kFloat,
                     Isa isa = ChooseIsa());
  SuperGlue(SuperGlue&&) noexcept;
  SuperGlue& operator=(SuperGlue&&) noexcept;
  ~SuperGlue();

  /// Size of the descriptors it matches, 256 in all published forms.
  int descriptor_size() const { return static_cast<int>(size_); }
  int layers() const;

  /// Floating-point operations of the scores of two sets of keypoints, as published: two for each
  /// multiply-add of encoder, attention with its merge layers, MLPs, projection and products.
  double Flops(int64_t keypoints0, int64_t keypoints1) const;

  /// The logarithm of the assignment matrix [(n0 + 1) x (n1 + 1)], dustbins last: a row sums to 1
  /// (the dustbin's to n1) where Sinkhorn has converged. Lives in the workspace until its next use.
  /// Throws Error for descriptors of another size and for keypoints without a score or a
  /// descriptor; needs at least one keypoint in each set.
  TensorView<float> LogAssignment(const Features& features0, const Features& features1,
                                  const SuperGlueOptions& options, Workspace& workspace) const;

  /// Mutual best pairs of the assignment above the threshold; none where a set is empty.
  void Match(const Features& features0, const Features& features1, const SuperGlueOptions& options,
             Workspace& workspace, Matches& matches) const;

 private:
  struct Network;  // In one precision.

  const kernels::Kernels* kernels_;
  int64_t size_ = 0;
  double keypoint_flops_ = 0.0;  // Of what concerns one keypoint alone.
  float dustbin_score_ = 0.0F;
  std::unique_ptr<const Network> network_;
};

}  // namespace gluevo::nn
