#pragma once

#include <cstdint>
#include <type_traits>

#include "gluevo/nn/isa.h"

// What every kernel computes, and on which layouts. Each has one reference implementation
// (reference.cc: plain loops that sum in double, the specification) and one written over Highway's
// vectors (the *-inl.h files), compiled once for each instruction set. Kernels do not allocate and
// know no threads: their callers give each thread a range of rows.
namespace gluevo::nn::kernels {

/// Channels of a block. Activations and packed weights have the same layout for every instruction
/// set, whatever its vector width: 16 floats are one cache line and the widest register.
inline constexpr int kBlock = 16;

inline constexpr int64_t BlocksOf(int64_t channels) { return (channels + kBlock - 1) / kBlock; }

/// Activations of a convolution network: channels in blocks of kBlock (the last one padded with
/// zeros), each block a plane of pixels with a halo of one pixel of zeros on every side:
/// [blocks][height + 2][width + 2][kBlock]. So a pixel's block is one cache line, the pixels of a
/// row follow each other at a distance known to the compiler, and a 3x3 window needs no border
/// case.
struct BlockedMap {
  float* data = nullptr;  ///< Of the halo's top-left corner; aligned to 64 bytes.
  int64_t blocks = 0;
  int64_t height = 0;  ///< Pixels without halo.
  int64_t width = 0;

  static int64_t Floats(int64_t blocks, int64_t height, int64_t width) {
    return blocks * (height + 2) * (width + 2) * kBlock;
  }
  int64_t row_stride() const { return (width + 2) * kBlock; }
  int64_t block_stride() const { return (height + 2) * row_stride(); }
  /// y in [-1, height], x in [-1, width].
  float* pixel(int64_t block, int64_t y, int64_t x) const {
    return data + block * block_stride() + (y + 1) * row_stride() + (x + 1) * kBlock;
  }
};

/// Zeros on the halo. Kernels never write it.
void ClearHalo(const BlockedMap& map);

/// out = pool(relu(conv3x3(in) + bias) * scale + shift), zero padding of one pixel, stride 1.
struct Conv3x3 {
  /// A BlockedMap; where `gray`, a plane of single floats with the same halo: [height+2][width+2].
  BlockedMap in;
  bool gray = false;
  /// Packed by PackConv3x3, for Kernels::winograd3x3 by PackWinograd3x3.
  const float* weights = nullptr;
  const float* bias = nullptr;  ///< [out.blocks * kBlock], zeros in the padding.
  bool relu = false;
  /// A batch normalisation that follows the activation: both [out.blocks * kBlock], or both null.
  const float* scale = nullptr;
  const float* shift = nullptr;
  /// 2x2 max-pooling at the end; an odd last row or column is dropped.
  bool pool = false;
  /// height and width of `in`, or half of them with `pool`; no other map than `in`.
  BlockedMap out;
  /// What to compute, in pixels before pooling: [row_begin, row_end) x [column_begin, column_end).
  /// With `pool` the begins are even.
  int64_t row_begin = 0;
  int64_t row_end = 0;
  int64_t column_begin = 0;
  int64_t column_end = 0;
  /// Kernels::winograd3x3: only these of the region's tiles of 4x4 pixels, ascending indices row by
  /// row; null for all of them.
  const int32_t* tiles = nullptr;
  int64_t tile_count = 0;
  /// Kernels::winograd3x3: WinogradScratchFloats(channels of in) floats, aligned, of this thread
  /// only.
  float* scratch = nullptr;
};

/// Floats that PackConv3x3 writes.
int64_t PackedConv3x3Floats(int64_t out_channels, int64_t in_channels);
/// Weights [out][in][3][3] as [out block][in block][3][3][in of the block][out of the block], with
/// zeros for padding channels. With in_channels == 1 (Conv3x3::gray) the block of inputs is 1 wide.
void PackConv3x3(const float* weights, int64_t out_channels, int64_t in_channels, float* packed);

/// Two bfloat16 (the upper halves of floats) of neighbouring channels: an element of the operands
/// of products in bf16, as wide as a float. So both precisions have the same layouts, and a block
/// of kBlock elements is 16 channels of the one, 32 of the other.
struct Bf16Pair {
  uint16_t low = 0;  ///< The channel of even index.
  uint16_t high = 0;
};

/// Channels of an element.
template <typename Element>
inline constexpr int kChannelsPer = std::is_same_v<Element, float> ? 1 : 2;

/// Blocks of elements that hold so many channels.
template <typename Element>
constexpr int64_t ElementBlocks(int64_t channels) {
  return BlocksOf((channels + kChannelsPer<Element> - 1) / kChannelsPer<Element>);
}

/// c = relu(a0 b[:k0] + a1 b[k0:] + bias) + residual, sums in float. Operands on the left are rows
/// in blocks of elements, [block][row][kBlock], padding channels zero; they may come in two parts
/// that are never concatenated. The right side is packed and mostly constant.
template <typename Element>
struct MatMul {
  const Element* a0 = nullptr;  ///< First row.
  int64_t a0_block_stride = 0;  ///< Elements from a block to the next.
  int64_t a0_blocks = 0;
  const Element* a1 = nullptr;
  int64_t a1_block_stride = 0;
  int64_t a1_blocks = 0;
  const Element* b = nullptr;   ///< Packed by PackMatrix.
  const float* bias = nullptr;  ///< [columns rounded up to kBlock], zeros in the padding; or null.
  bool relu = false;
  const float* residual = nullptr;  ///< Laid out like c, may be c itself; or null.
  /// Element (row, column) at c[row * c_stride + column / kBlock * c_block_stride + column %
  /// kBlock]; null where only the rounded result is wanted.
  float* c = nullptr;
  int64_t c_stride = kBlock;
  int64_t c_block_stride = 0;
  /// The result rounded to the nearest, as a left operand: [block][row][kBlock]; or null.
  Bf16Pair* rounded = nullptr;
  int64_t rounded_block_stride = 0;
  int64_t columns = 0;  ///< Of c, which is not touched beyond; `rounded` is whole blocks.
  int64_t rows = 0;
};

/// Elements that PackMatrix writes.
template <typename Element>
constexpr int64_t PackedMatrixSize(int64_t out_features, int64_t in_features) {
  return BlocksOf(out_features) * kBlock * ElementBlocks<Element>(in_features) * kBlock;
}
/// Weights [out][in], rows `stride` floats apart, as [out block][in element][out of the block] with
/// zeros for padding.
template <typename Element>
void PackMatrix(const float* weights, int64_t stride, int64_t out_features, int64_t in_features,
                Element* packed);

/// Rows of a left operand, [block][row][kBlock], as rows of a right one (its transpose): packed
/// [row block][block * kBlock + i][kBlock rows], zeros for the padding of a last block of rows.
template <typename Element>
void PackRows(const Element* rows, int64_t block_stride, int64_t blocks, int64_t count,
              Element* packed);

/// One head of attention (Vaswani et al. 2017): out = softmax(q k^T) v, the factor 1/sqrt(d) being
/// part of q already. d is a multiple of the channels of a block of elements.
template <typename Element>
struct Attention {
  const Element* q = nullptr;  ///< [block][query][kBlock]
  int64_t q_block_stride = 0;
  int64_t head_blocks = 0;  ///< Blocks of elements of q and k.
  /// Packed by PackRows: [key block][head_blocks * kBlock][kBlock keys], zeros for padding keys.
  const Element* k = nullptr;
  /// Right operand of the second product, an element being one or two keys' values of a channel:
  /// [channel / kBlock][key element][kBlock]; zeros for padding keys, up to a whole block of
  /// elements.
  const Element* v = nullptr;
  int64_t v_block_stride = 0;
  int64_t keys = 0;
  Element* out = nullptr;  ///< Laid out like q.
  int64_t out_block_stride = 0;
  int64_t queries = 0;
  float* scratch = nullptr;  ///< AttentionScratchFloats(keys) floats, aligned, of this thread only.
};

/// Queries whose scores are in scratch at a time: two register tiles of the widest set.
inline constexpr int64_t kAttentionRows = 28;

inline constexpr int64_t AttentionScratchFloats(int64_t keys) {
  return kAttentionRows * BlocksOf(keys) * kBlock;
}

/// Rows of a left operand in bf16, [block][row][kBlock], as Attention::v: a pair holds one channel
/// of two rows. `count` may be odd.
void PackValues(const Bf16Pair* rows, int64_t block_stride, int64_t blocks, int64_t count,
                Bf16Pair* packed, int64_t packed_block_stride);

/// SuperPoint's detector head: softmax over the 65 logits of each cell, the 65th (no keypoint here)
/// dropped, and the 8x8 others put at their pixels.
struct DetectorSoftmax {
  const float* logits = nullptr;  ///< [cell rows * cell columns][stride], 65 of them used.
  int64_t stride = 0;
  int64_t cell_columns = 0;
  float* scores = nullptr;  ///< [8 * cell rows][8 * cell columns]
  int64_t cell_row_begin = 0;
  int64_t cell_row_end = 0;
};

/// Rows [row_begin, row_end) of k_ij = exp(z_ij + u_i + v_j): a transport plan, or the kernel that
/// Sinkhorn's iterations scale to one. Entries below exp(-80) and the padding of rows become 0.
struct SinkhornExponentials {
  const float* z = nullptr;  ///< [rows][stride], stride a multiple of kBlock; padding is ignored.
  int64_t stride = 0;
  int64_t columns = 0;
  const float* u = nullptr;  ///< [rows]
  const float* v = nullptr;  ///< [stride]
  float* k = nullptr;        ///< [rows][stride]
  int64_t row_begin = 0;
  int64_t row_end = 0;
};

/// Rows [row_begin, row_end) of one Sinkhorn iteration (Cuturi 2013):
///   a_i = mu_i / sum_j k_ij b_j,   column_sums_j += k_ij a_i.
/// The caller then sets b_j to nu_j over the column's sum.
struct SinkhornRows {
  const float* k = nullptr;  ///< [rows][stride], stride a multiple of kBlock, zeros in the padding.
  int64_t stride = 0;
  const float* b = nullptr;      ///< [stride], finite in the padding.
  const float* mu = nullptr;     ///< [rows]
  float* a = nullptr;            ///< [rows]
  float* column_sums = nullptr;  ///< [stride]; added to.
  int64_t row_begin = 0;
  int64_t row_end = 0;
};

/// out_i = sum_j a_j b_ij, exactly, of values from -127 to 127.
struct ByteProducts {
  const int8_t* a = nullptr;  ///< [size]
  const int8_t* b = nullptr;  ///< [rows][size]
  int64_t size = 0;           ///< A multiple of kByteBlock, at most kMaxBytes.
  int64_t rows = 0;
  int32_t* out = nullptr;  ///< [rows]
};

/// As wide as the widest register; and how many products of bytes are no larger than an int32_t.
inline constexpr int64_t kByteBlock = 64;
inline constexpr int64_t kMaxBytes = INT32_MAX / (127 * 127) / kByteBlock * kByteBlock;

/// Bound of the relative error of the fast kernels' exponential: 1.8 units of 2^-24 of its
/// polynomial, the rest of rounding.
inline constexpr double kExpError = 6 * 0x1p-24;

/// The kernels of one instruction set.
struct Kernels {
  Isa isa = Isa::kReference;
  /// Direct convolution: every shape, and the check of the other.
  void (*conv3x3)(const Conv3x3&) = nullptr;
  /// The same by Winograd's F(4x4, 3x3), for maps that are not `gray`; null where there is none.
  void (*winograd3x3)(const Conv3x3&) = nullptr;
  void (*matmul)(const MatMul<float>&) = nullptr;
  void (*matmul_bf16)(const MatMul<Bf16Pair>&) = nullptr;
  void (*attention)(const Attention<float>&) = nullptr;
  void (*attention_bf16)(const Attention<Bf16Pair>&) = nullptr;
  void (*detector_softmax)(const DetectorSoftmax&) = nullptr;
  void (*sinkhorn_exponentials)(const SinkhornExponentials&) = nullptr;
  void (*sinkhorn_rows)(const SinkhornRows&) = nullptr;
  void (*byte_products)(const ByteProducts&) = nullptr;
  /// Floating-point operations a second of one thread that does nothing but multiply-adds on
  /// registers, over `seconds`: the peak that shares are quoted of.
  double (*peak_flops)(double seconds) = nullptr;
  /// The same for products in bf16 with sums in float.
  double (*peak_flops_bf16)(double seconds) = nullptr;
};

template <typename Element>
void Multiply(const Kernels& kernels, const MatMul<Element>& p) {
  if constexpr (std::is_same_v<Element, float>) {
    kernels.matmul(p);
  } else {
    kernels.matmul_bf16(p);
  }
}

template <typename Element>
void Attend(const Kernels& kernels, const Attention<Element>& p) {
  if constexpr (std::is_same_v<Element, float>) {
    kernels.attention(p);
  } else {
    kernels.attention_bf16(p);
  }
}

/// Throws Error unless SupportedIsas() has it.
const Kernels& KernelsFor(Isa isa);

}  // namespace gluevo::nn::kernels
