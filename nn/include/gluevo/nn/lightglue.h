#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "gluevo/nn/features.h"
#include "gluevo/nn/isa.h"
#include "gluevo/nn/tensor.h"
#include "gluevo/nn/weights.h"
#include "gluevo/nn/workspace.h"

namespace gluevo::nn {

class LightGlueNetwork;

struct LightGlueOptions {
  /// Matches have a confidence above this, 0 to 1.
  float match_threshold = 0.1F;
  /// Adaptive depth (section 3.3 of the paper): no more layers once more than this share of the
  /// keypoints is sure that its match will not change, 0 to 1; 0: always all layers.
  float depth_confidence = 0.95F;
  /// Adaptive width: between layers keypoints leave that are sure of their match and, with more
  /// than this confidence, that they have none, 0 to 1; 0: none leaves.
  float width_confidence = 0.99F;

  /// Throws Error naming the field that is out of range.
  void Validate() const;
};

/// How much of the network two images took.
struct LightGlueEffort {
  int layers = 0;
  /// For each keypoint, 1 and one for each time that keypoints left and it stayed.
  std::vector<int> rounds0;
  std::vector<int> rounds1;
};

/// LightGlue (Lindenberger et al. 2023): matches two sets of keypoints by layers of self- and
/// cross-attention with rotary encoding of positions, and a double softmax; stops early and drops
/// keypoints where it is sure. Widths, heads and number of layers are those of the weights. Scores
/// of keypoints are not used.
class LightGlue {
 public:
  /// Throws Error naming the file and the tensor for weights that are not a LightGlue's.
  explicit LightGlue(const Weights& weights, Isa isa = ChooseIsa());
  LightGlue(LightGlue&&) noexcept;
  LightGlue& operator=(LightGlue&&) noexcept;
  ~LightGlue();

  /// Size of the descriptors it matches: 128 for ALIKED and DISK, 256 for SuperPoint.
  int descriptor_size() const;
  int layers() const;
  /// The weights can tell when to stop; else depth_confidence must be 0.
  bool has_adaptive_depth() const;

  /// Floating-point operations of `layers` layers and the assignment of two sets of keypoints, as
  /// published: two for each multiply-add of projections, attention, MLPs and products.
  double Flops(int64_t keypoints0, int64_t keypoints1, int layers) const;

  /// The logarithm of the assignment [(n0 + 1) x (n1 + 1)] of all keypoints after all layers, that
  /// of having no match in the last row and column. Lives in the workspace until its next use.
  /// Throws Error for descriptors of another size and keypoints without one; needs at least one
  /// keypoint in each set.
  TensorView<float> LogAssignment(const Features& features0, const Features& features1,
                                  Workspace& workspace) const;

  /// Mutual best pairs of the assignment above the threshold; none where a set is empty. `effort`
  /// may be null.
  void Match(const Features& features0, const Features& features1, const LightGlueOptions& options,
             Workspace& workspace, Matches& matches, LightGlueEffort* effort = nullptr) const;

 private:
  std::unique_ptr<const LightGlueNetwork> network_;
  double layer_flops_ = 0.0;  // Of what concerns one keypoint alone, a layer.
  double other_flops_ = 0.0;  // The same before the first layer and after the last one.
};

}  // namespace gluevo::nn
