#pragma once

#include <cstdint>

#include "affine.h"
#include "gluevo/nn/tensor.h"
#include "kernels/kernels.h"

namespace gluevo::nn {

/// Channels in whole blocks of elements.
template <typename Element>
int64_t PaddedChannels(int64_t channels) {
  return kernels::ElementBlocks<Element>(channels) * kernels::kBlock *
         kernels::kChannelsPer<Element>;
}

/// A product with packed weights; the left operand may have a second part.
template <typename Operand>
struct Linear {
  int64_t blocks0 = 0;
  int64_t blocks1 = 0;
  int64_t columns = 0;  ///< Whole blocks.
  const Operand* weights = nullptr;
  Tensor<float> bias;
};

/// The product of `count` rows, whose blocks of channels lie `block_stride` elements apart; where
/// its result goes is for the caller to say.
template <typename Operand>
kernels::MatMul<Operand> Product(const Linear<Operand>& linear, const Operand* rows,
                                 int64_t block_stride, int64_t count) {
  return {.a0 = rows,
          .a0_block_stride = block_stride,
          .a0_blocks = linear.blocks0,
          .b = linear.weights,
          .bias = linear.bias.data(),
          .columns = linear.columns,
          .rows = count};
}

/// Packs products one after the other into memory that has room for them. Weights that are used one
/// after the other lie so in memory: what a product fetches ahead beyond its last columns is the
/// beginning of the next product's.
template <typename Operand>
class Packer {
 public:
  explicit Packer(Tensor<Operand>& storage) : to_(storage.data()) {}

  /// `columns`: whole blocks, at least as many as the map has outputs.
  Linear<Operand> Pack(const Affine& affine, int64_t columns);

 private:
  Operand* to_;
};

/// Heads of equal numbers of rows moved to where heads of `padded` rows begin, zeros between them.
Affine PadHeads(const Affine& affine, int64_t heads, int64_t padded);

extern template class Packer<float>;
extern template class Packer<kernels::Bf16Pair>;

}  // namespace gluevo::nn
