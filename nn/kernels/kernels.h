#pragma once

#include <cstdint>

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
  /// Kernels::winograd3x3: WinogradScratchFloats(channels of in) floats, aligned, of this thread
  /// only.
  float* scratch = nullptr;
};

/// Floats that PackConv3x3 writes.
int64_t PackedConv3x3Floats(int64_t out_channels, int64_t in_channels);
/// Weights [out][in][3][3] as [out block][in block][3][3][in of the block][out of the block], with
/// zeros for padding channels. With in_channels == 1 (Conv3x3::gray) the block of inputs is 1 wide.
void PackConv3x3(const float* weights, int64_t out_channels, int64_t in_channels, float* packed);

/// c = relu(a0 b[:k0] + a1 b[k0:] + bias) + residual: a product of row-major matrices with a
/// packed, constant right side. The left side may come in two parts that are never concatenated.
struct MatMul {
  /// [rows][k0]: element k of a row at a0[row * a0_stride + k / kBlock * a0_block_stride +
  /// k % kBlock]. Row-major with the default; a row of pixels of a BlockedMap with its strides.
  const float* a0 = nullptr;
  int64_t a0_stride = 0;
  int64_t a0_block_stride = kBlock;
  int64_t k0 = 0;
  const float* a1 = nullptr;  ///< Row-major, or nothing with k1 = 0.
  int64_t a1_stride = 0;
  int64_t k1 = 0;
  const float* b = nullptr;     ///< Packed by PackMatrix, k0 + k1 inputs.
  const float* bias = nullptr;  ///< [columns rounded up to kBlock], zeros in the padding; or null.
  bool relu = false;
  const float* residual = nullptr;  ///< [rows][columns] with c's stride, may be c itself; or null.
  float* c = nullptr;
  int64_t c_stride = 0;
  int64_t columns = 0;  ///< Columns to write; the rest of a last block is not touched.
  int64_t row_begin = 0;
  int64_t row_end = 0;
};

int64_t PackedMatrixFloats(int64_t out_features, int64_t in_features);
/// Weights [out][in], rows `stride` floats apart, as [out block][in][out of the block].
void PackMatrix(const float* weights, int64_t stride, int64_t out_features, int64_t in_features,
                float* packed);

/// One head of attention (Vaswani et al. 2017): out = softmax(q k^T) v, the factor 1/sqrt(d) being
/// part of q already.
struct Attention {
  const float* q = nullptr;  ///< [queries][head_dim], rows q_stride apart.
  int64_t q_stride = 0;
  /// Packed by PackMatrix from k [keys][head_dim]: [key block][head_dim][kBlock].
  const float* k_packed = nullptr;
  const float* v = nullptr;  ///< [keys][head_dim rounded up to kBlock], contiguous, zero padding.
  int64_t keys = 0;
  int64_t head_dim = 0;
  float* out = nullptr;  ///< [queries][head_dim], rows out_stride apart.
  int64_t out_stride = 0;
  int64_t row_begin = 0;  ///< Queries to compute.
  int64_t row_end = 0;
  float* scratch = nullptr;  ///< AttentionScratchFloats(keys) floats, aligned, of this thread only.
};

/// Query rows whose scores are in scratch at a time.
inline constexpr int64_t kAttentionRows = 32;

inline constexpr int64_t AttentionScratchFloats(int64_t keys) {
  return kAttentionRows * BlocksOf(keys) * kBlock;
}

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

/// Rows [row_begin, row_end) of one Sinkhorn iteration in the log domain (SuperGlue, section 3.3).
/// With m_i the largest z_ij + v_j of row i, e_ij = exp(z_ij + v_j - m_i) and s_i its sum:
///   u_i = log_mu_i - m_i - log s_i,   column_sums_j += e_ij * exp(log_mu_i) / s_i.
/// The caller then sets v_j <- v_j + log_nu_j - log(column_sums_j): the same mathematics as two
/// log-sum-exps, with one exponential an entry.
struct SinkhornRows {
  const float* z = nullptr;  ///< [rows][stride], stride a multiple of kBlock; padding is ignored.
  int64_t stride = 0;
  int64_t columns = 0;
  const float* v = nullptr;       ///< [columns rounded up to kBlock]
  const float* log_mu = nullptr;  ///< [rows]
  float* u = nullptr;             ///< [rows]
  float* column_sums = nullptr;   ///< [columns rounded up to kBlock]; added to.
  float* scratch = nullptr;       ///< [columns rounded up to kBlock], of this thread only.
  int64_t row_begin = 0;
  int64_t row_end = 0;
};

/// The kernels of one instruction set.
struct Kernels {
  Isa isa = Isa::kReference;
  /// Direct convolution: every shape, and the check of the other.
  void (*conv3x3)(const Conv3x3&) = nullptr;
  /// The same by Winograd's F(4x4, 3x3), for maps that are not `gray`; null where there is none.
  void (*winograd3x3)(const Conv3x3&) = nullptr;
  void (*matmul)(const MatMul&) = nullptr;
  void (*attention)(const Attention&) = nullptr;
  void (*detector_softmax)(const DetectorSoftmax&) = nullptr;
  void (*sinkhorn_rows)(const SinkhornRows&) = nullptr;
  /// Floating-point operations a second of one thread that does nothing but multiply-adds on
  /// registers, over `seconds`: the peak that shares are quoted of.
  double (*peak_flops)(double seconds) = nullptr;
};

/// Throws Error unless SupportedIsas() has it.
const Kernels& KernelsFor(Isa isa);

}  // namespace gluevo::nn::kernels
