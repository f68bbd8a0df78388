// Product of rows in blocks of elements with a packed matrix.

#if defined(GLUEVO_NN_KERNELS_MATMUL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_MATMUL_INL_H_
#undef GLUEVO_NN_KERNELS_MATMUL_INL_H_
#else
#define GLUEVO_NN_KERNELS_MATMUL_INL_H_
#endif

#include <algorithm>
#include <limits>

#include "kernels/tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

// Rows that share one panel of b while it is close.
inline constexpr int64_t kRowChunk = 56;

// max(this, sum) is the ReLU or nothing, and in this order what is not a number stays so.
template <typename Element>
HWY_INLINE Vector LeastOf(const MatMul<Element>& p) {
  return hn::Set(Tag(), p.relu ? 0.0F : -std::numeric_limits<float>::infinity());
}

// Sums of `rows` rows of one vector of columns, `stride` floats apart, to their places: ReLU,
// residual, rounding.
template <typename Element>
HWY_INLINE void StoreColumns(const MatMul<Element>& p, const float* HWY_RESTRICT sums,
                             int64_t stride, int64_t row, int64_t rows, int64_t column) {
  const Tag d;
  const Vector least = LeastOf(p);
  const int64_t at = row * p.c_stride + column / kBlock * p.c_block_stride + column % kBlock;
  float* c = p.c != nullptr ? p.c + at : nullptr;
  const float* residual = p.residual != nullptr ? p.residual + at : nullptr;
  Bf16Pair* rounded =
      p.rounded != nullptr
          ? p.rounded + column / (2 * kBlock) * p.rounded_block_stride + row * kBlock
          : nullptr;
  const int lane = static_cast<int>(column % (2 * kBlock));
  const int64_t count = std::min<int64_t>(kLanes, p.columns - column);
  for (int64_t r = 0; r < rows; ++r, sums += stride) {
    Vector value = hn::Max(least, hn::Load(d, sums));
    if (HWY_LIKELY(count == kLanes)) {
      if (residual != nullptr) {
        value = hn::Add(value, hn::LoadU(d, residual + r * p.c_stride));
      }
      if (c != nullptr) {
        hn::StoreU(value, d, c + r * p.c_stride);
      }
    } else {
      alignas(64) float lanes[kLanes] = {};
      hn::Store(value, d, lanes);
      for (int64_t i = 0; i < count; ++i) {
        lanes[i] += residual != nullptr ? residual[r * p.c_stride + i] : 0.0F;
        if (c != nullptr) {
          c[r * p.c_stride + i] = lanes[i];
        }
      }
      value = hn::Load(d, lanes);
    }
    if (rounded != nullptr) {
      StoreChannels(value, rounded + r * kBlock, lane);
    }
  }
}

// Not part of the tile's own code, which is there once for every height and would be ten times as
// long.
template <int kVectors, typename Element>
HWY_NOINLINE void StoreRows(const MatMul<Element>& p, const float* HWY_RESTRICT sums, int64_t row,
                            int64_t rows, int64_t column) {
  for (int v = 0; v < kVectors; ++v) {
    StoreColumns(p, sums + v * kLanes, kVectors * kLanes, row, rows, column + v * kLanes);
  }
}

template <int kVectors, typename Element>
HWY_NOINLINE void MultiplyPanel(const MatMul<Element>& p, int64_t row_begin, int64_t row_end,
                                int64_t column) {
  const int64_t b_block_stride = (p.a0_blocks + p.a1_blocks) * kBlock * kBlock;
  const Element* const b = p.b + column / kBlock * b_block_stride + column % kBlock;
  // The next columns' panel, which is far away: all weights of a network pass through.
  constexpr int64_t kPanelBlocks = (kVectors * kLanes + kBlock - 1) / kBlock;
  Ahead<Element> ahead =
      PanelAhead<kVectors>(b + kPanelBlocks * b_block_stride, row_end - row_begin);
  // Most products need nothing but this.
  const bool plain = p.c != nullptr && p.residual == nullptr && p.rounded == nullptr &&
                     column + kVectors * kLanes <= p.columns;
  const Vector least = LeastOf(p);
  ForBalancedTiles(row_begin, row_end, [&]<int kRows>(int64_t row) HWY_ATTR {
    Tile<kRows, kVectors> tile;
    InitTile(tile, p.bias != nullptr ? p.bias + column : nullptr);
    AccumulateBlocks(tile, p.a0 + row * kBlock, p.a0_block_stride, p.a0_blocks, b, b_block_stride,
                     ahead);
    AccumulateBlocks(tile, p.a1 + row * kBlock, p.a1_block_stride, p.a1_blocks,
                     b + p.a0_blocks * kBlock * kBlock, b_block_stride, ahead);
    if (HWY_LIKELY(plain)) {
      float* c = p.c + row * p.c_stride + column / kBlock * p.c_block_stride + column % kBlock;
      HWY_UNROLL(16)
      for (int r = 0; r < kRows; ++r, c += p.c_stride) {
        HWY_UNROLL(16)
        for (int v = 0; v < kVectors; ++v) {
          hn::StoreU(hn::Max(least, tile.v[r][v]), Tag(), c + VectorOffset(v, p.c_block_stride));
        }
      }
      return;
    }
    alignas(64) float sums[kRows * kVectors * kLanes];
    StoreTile(tile, sums);
    StoreRows<kVectors>(p, sums, row, kRows, column);
  });
}

template <typename Element>
void FastMatMul(const MatMul<Element>& p) {
  const int64_t padded_columns = BlocksOf(p.columns) * kBlock;
  for (int64_t row = 0; row < p.rows; row += kRowChunk) {
    const int64_t row_end = std::min(row + kRowChunk, p.rows);
    int64_t column = 0;
    for (; column + kTileVectors * kLanes <= padded_columns; column += kTileVectors * kLanes) {
      MultiplyPanel<kTileVectors>(p, row, row_end, column);
    }
    for (; column < padded_columns; column += kLanes) {
      MultiplyPanel<1>(p, row, row_end, column);
    }
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
