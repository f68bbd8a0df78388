#pragma once

#include <array>
#include <cstdint>

#include "gluevo/nn/features.h"
#include "gluevo/nn/lightglue.h"
#include "gluevo/nn/workspace.h"
#include "graph_network_bands.h"
#include "kernels/kernels.h"
#include "kernels/open_kernels.h"
#include "lightglue_layers.h"

namespace gluevo::nn {

/// What the layers know of one image; all of it is in an arena.
struct LightGlueImage {
  /// Of self- and of cross-attention, which the bands of a step read and write in turn.
  struct Keys {
    float* q;  ///< [block][row][kBlock], as are all but:
    float* k;  ///< Packed by PackRows, head after head.
    float* v;
  };

  LightGlueImage(const Features& features_in, const LightGlueLayers& layers, Arena& arena);

  const Features* features;
  int64_t count;   ///< Keypoints that are still there.
  int64_t stride;  ///< Floats from a block to the next.
  float* tokens;
  float* cosines;  ///< Of the angles of rotary encoding: [half_blocks][row][kBlock].
  float* sines;
  std::array<Keys, 2> keys;
  float* logits;  ///< [row][kBlock]: 0 of matchability, 1 of confidence, after the last layer run.
  float* projected;  ///< By the final projection; of image 1, packed by PackRows.
  int32_t* indices;  ///< Of the keypoints that are still there, ascending.
  int32_t* rounds;   ///< As LightGlueEffort has them, for every keypoint.
};

struct LightGlueState {
  std::array<LightGlueImage, 2> images;
  int64_t layers = 0;  ///< That have been run.
};

/// The layers of a LightGlue (Lindenberger et al. 2023, section 3), with adaptive depth and width.
///
/// As in GraphNetwork all activations are left operands of products, and what follows attention is
/// done for a band of keypoints in one go. The steps of a layer are loops of their own, since after
/// each layer it is seen who goes on.
class LightGlueNetwork {
 public:
  LightGlueNetwork(const LightGlueWeights& weights, Isa isa)
      : kernels_(&kernels::KernelsFor(isa)),
        open_(&kernels::OpenKernelsFor(isa)),
        layers_(weights) {}

  const LightGlueLayers& layers() const { return layers_; }
  const kernels::OpenKernels& kernels() const { return *open_; }

  /// Both images have at least one keypoint, with descriptors of the right size. Runs at most so
  /// many of the attention blocks, two a layer.
  LightGlueState Run(const Features& features0, const Features& features1,
                     const LightGlueOptions& options, int64_t most_blocks,
                     Workspace& workspace) const;

  /// Scores [n0 x whole blocks of n1] of the keypoints that are left after the last layer run, of
  /// which there are some in both images.
  TensorView<float> Similarity(LightGlueState& state, Workspace& workspace) const;

 private:
  using Layer = LightGlueLayers::Layer;
  struct Scratch;

  // Tokens and angles.
  void Encode(const Band& band, LightGlueImage& image, const Scratch& scratch) const;
  void ProjectSelf(const Layer& layer, const Band& band, LightGlueImage& image,
                   const Scratch& scratch) const;
  void ProjectCross(const Layer& layer, const Band& band, LightGlueImage& image,
                    const Scratch& scratch) const;
  // Keys, from `scratch`, and values to their places.
  void StoreKeys(const Linear<float>& values, const Band& band, LightGlueImage& image, int set,
                 const Scratch& scratch) const;
  // x + mlp(x, attention), of self-attention (set 0) or cross-attention (set 1).
  void Attend(const LightGlueLayers::Mlp& mlp, const Band& band, LightGlueImage& image,
              const LightGlueImage& source, int set, const Scratch& scratch) const;
  void Decide(const Layer& layer, const Band& band, LightGlueImage& image) const;
  // After layer `layer`, both by the published rules.
  bool StopsAfter(int64_t layer, const LightGlueOptions& options,
                  const LightGlueState& state) const;
  void Prune(int64_t layer, const LightGlueOptions& options, LightGlueImage& image) const;
  // c below it is not sure yet, with c = sigmoid(logit of confidence).
  float ConfidenceThreshold(int64_t layer) const;

  const kernels::Kernels* kernels_;
  const kernels::OpenKernels* open_;
  LightGlueLayers layers_;
};

}  // namespace gluevo::nn
