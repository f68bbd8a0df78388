#pragma once

#include <cstdint>

#include "gluevo/nn/features.h"
#include "gluevo/nn/workspace.h"
#include "graph_network_bands.h"
#include "graph_network_weights.h"
#include "kernels/kernels.h"
#include "superglue_weights.h"

namespace gluevo::nn {

/// The final descriptors of both images; in the workspace until its next use.
struct Projected {
  /// Of image 0: [block][row][kBlock].
  const float* rows0 = nullptr;
  int64_t rows0_block_stride = 0;
  int64_t blocks = 0;
  /// Of image 1, packed as right operand of a product by PackRows.
  const float* packed1 = nullptr;
};

/// SuperGlue's keypoint encoder, its layers of self- and cross-attention and the final projection
/// (Sarlin et al. 2020, sections 3.1 and 3.2), with products of floats or of bf16 pairs. Sums,
/// tokens and the encoder, whose inputs are coordinates, are floats in both.
///
/// All activations are left operands of products, [block][row][kBlock], so no product copies them.
/// A layer works on bands of keypoints: what follows attention concerns each keypoint alone and is
/// done in one go, up to the next layer's queries, keys and values.
template <typename Element>
class GraphNetwork {
 public:
  GraphNetwork(const SuperGlueWeights& weights, const kernels::Kernels& kernels)
      : kernels_(&kernels), weights_(weights) {}

  int layers() const { return static_cast<int>(weights_.layers.size()); }

  /// Both images have at least one keypoint, with descriptors of the right size.
  Projected Run(const Features& features0, const Features& features1, Workspace& workspace) const;

 private:
  using Layer = typename GraphNetworkWeights<Element>::Layer;
  struct Image;
  struct Scratch;
  struct Shared;

  // One band's way through a step: step 0 encodes, step i + 1 is layer i, and the last one
  // projects. Waits for those bands of the steps before whose results it reads.
  void RunStep(int64_t step, int64_t index, Shared& shared, Scratch& scratch) const;

  // Token = descriptor + encoder(position and score).
  void Encode(const Features& features, const Band& band, Image& image, Scratch& scratch) const;
  // Queries, keys and values of a layer.
  void Project(const Layer& layer, const Band& band, Image& image, int key_set,
               Scratch& scratch) const;
  void RunLayer(const Layer& layer, const Band& band, Image& image, const Image& source,
                int key_set, Scratch& scratch) const;
  void ProjectLast(const Band& band, Image& image, Scratch& scratch) const;

  const kernels::Kernels* kernels_;
  GraphNetworkWeights<Element> weights_;
};

extern template class GraphNetwork<float>;
extern template class GraphNetwork<kernels::Bf16Pair>;

}  // namespace gluevo::nn
