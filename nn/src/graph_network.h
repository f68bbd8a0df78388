#pragma once

#include <cstdint>
#include <vector>

#include "gluevo/nn/features.h"
#include "gluevo/nn/tensor.h"
#include "gluevo/nn/workspace.h"
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
  GraphNetwork(const SuperGlueWeights& weights, const kernels::Kernels& kernels);

  int layers() const { return static_cast<int>(layers_.size()); }

  /// Both images have at least one keypoint, with descriptors of the right size.
  Projected Run(const Features& features0, const Features& features1, Workspace& workspace) const;

 private:
  // A product with packed weights; the left operand may have a second part.
  template <typename Operand>
  struct Linear {
    int64_t blocks0 = 0;
    int64_t blocks1 = 0;
    int64_t columns = 0;  // Whole blocks.
    Tensor<Operand> weights;
    Tensor<float> bias;
  };
  struct Layer {
    Linear<Element> q, k, v, mlp_in, mlp_out;
  };
  struct Image;
  struct Scratch;
  struct Band;

  template <typename Operand>
  static Linear<Operand> Pack(const Affine& affine, int64_t columns);
  template <typename Operand>
  kernels::MatMul<Operand> Product(const Linear<Operand>& linear, const Operand* rows,
                                   int64_t block_stride, int64_t count) const;

  void Encode(const Features& features, const Band& band, Image& image, Scratch& scratch) const;
  void Project(const Layer& layer, const Band& band, Image& image, int key_set,
               Scratch& scratch) const;
  void RunLayer(const Layer& layer, const Band& band, Image& image, const Image& source,
                int key_set, Scratch& scratch) const;

  const kernels::Kernels* kernels_;
  int64_t size_ = 0;
  int64_t heads_ = 0;
  int64_t head_size_ = 0;    // Channels of a head, whole blocks of elements.
  int64_t hidden_size_ = 0;  // Widest of the layers' hidden ones, whole blocks of elements.
  int64_t widest_ = 0;       // Of the encoder, whole blocks.
  std::vector<Linear<float>> encoder_;
  std::vector<Layer> layers_;
  Linear<Element> final_;
};

extern template class GraphNetwork<float>;
extern template class GraphNetwork<kernels::Bf16Pair>;

}  // namespace gluevo::nn
