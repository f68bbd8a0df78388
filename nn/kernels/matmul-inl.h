// Product of row-major rows with a packed matrix, and attention, which is two of them around a
// softmax.

#if defined(GLUEVO_NN_KERNELS_MATMUL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_MATMUL_INL_H_
#undef GLUEVO_NN_KERNELS_MATMUL_INL_H_
#else
#define GLUEVO_NN_KERNELS_MATMUL_INL_H_
#endif

#include <hwy/contrib/math/math-inl.h>

#include <algorithm>

#include "kernels/tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::HWY_NAMESPACE {

// Rows that share one panel of b while it is in the first-level cache.
inline constexpr int64_t kRowChunk = 42;

template <int kVectors>
HWY_INLINE void MultiplyPanel(const MatMul& p, int64_t row_begin, int64_t row_end, int64_t column) {
  const Tag d;
  const int64_t depth = p.k0 + p.k1;
  const int64_t block_stride = depth * kBlock;
  const float* const b = p.b + column / kBlock * block_stride + column % kBlock;
  const bool whole = column + kVectors * kLanes <= p.columns;

  ForRowTiles(row_begin, row_end, [&]<int kRows>(int64_t row) HWY_ATTR {
    Tile<kRows, kVectors> tile;
    InitTile(tile, p.bias != nullptr ? p.bias + column : nullptr);
    const float* a = p.a0 + row * p.a0_stride;
    if (p.a0_block_stride == kBlock) {
      Accumulate(tile, a, p.a0_stride, b, kBlock, block_stride, p.k0);
    } else {
      for (int64_t k = 0; k < p.k0; k += kBlock, a += p.a0_block_stride) {
        Accumulate(tile, a, p.a0_stride, b + k * kBlock, kBlock, block_stride,
                   std::min<int64_t>(kBlock, p.k0 - k));
      }
    }
    if (p.k1 > 0) {
      Accumulate(tile, p.a1 + row * p.a1_stride, p.a1_stride, b + p.k0 * kBlock, kBlock,
                 block_stride, p.k1);
    }
    if (p.relu) {
      Relu(tile);
    }
    for (int r = 0; r < kRows; ++r) {
      const int64_t at = (row + r) * p.c_stride + column;
      if (whole) {
        HWY_UNROLL(16)
        for (int v = 0; v < kVectors; ++v) {
          Vector value = tile.v[r][v];
          if (p.residual != nullptr) {
            value = hn::Add(value, hn::LoadU(d, p.residual + at + v * kLanes));
          }
          hn::StoreU(value, d, p.c + at + v * kLanes);
        }
      } else {
        alignas(64) float values[kVectors * kLanes];
        for (int v = 0; v < kVectors; ++v) {
          hn::Store(tile.v[r][v], d, values + v * kLanes);
        }
        for (int64_t i = 0; i < std::min<int64_t>(kVectors * kLanes, p.columns - column); ++i) {
          p.c[at + i] = values[i] + (p.residual != nullptr ? p.residual[at + i] : 0.0F);
        }
      }
    }
  });
}

void FastMatMul(const MatMul& p) {
  const int64_t padded_columns = BlocksOf(p.columns) * kBlock;
  for (int64_t row = p.row_begin; row < p.row_end; row += kRowChunk) {
    const int64_t row_end = std::min(row + kRowChunk, p.row_end);
    int64_t column = 0;
    for (; column + kTileVectors * kLanes <= padded_columns; column += kTileVectors * kLanes) {
      MultiplyPanel<kTileVectors>(p, row, row_end, column);
    }
    for (; column < padded_columns; column += kLanes) {
      MultiplyPanel<1>(p, row, row_end, column);
    }
  }
}

// scores <- exp(scores - their largest), with zeros in the padding; returns 1 / sum.
HWY_INLINE float ExponentialsOfRow(float* HWY_RESTRICT scores, int64_t columns) {
  const Tag d;
  const int64_t padded = BlocksOf(columns) * kBlock;
  std::fill(scores + columns, scores + padded, hwy::LowestValue<float>());
  Vector largest = hn::Set(d, hwy::LowestValue<float>());
  for (int64_t j = 0; j < padded; j += kLanes) {
    largest = hn::Max(largest, hn::Load(d, scores + j));
  }
  largest = hn::MaxOfLanes(d, largest);
  Vector sum = hn::Zero(d);
  for (int64_t j = 0; j < padded; j += kLanes) {
    const Vector e = hn::Exp(d, hn::Sub(hn::Load(d, scores + j), largest));
    hn::Store(e, d, scores + j);
    sum = hn::Add(sum, e);
  }
  return 1.0F / hn::GetLane(hn::SumOfLanes(d, sum));
}

template <int kVectors>
HWY_INLINE void ScoresPanel(const Attention& p, int64_t row_begin, int64_t rows, int64_t column,
                            int64_t padded_keys) {
  const Tag d;
  const int64_t block_stride = p.head_dim * kBlock;
  const float* const k = p.k_packed + column / kBlock * block_stride + column % kBlock;
  ForRowTiles(0, rows, [&]<int kRows>(int64_t row) HWY_ATTR {
    Tile<kRows, kVectors> tile;
    InitTile(tile, nullptr);
    Accumulate(tile, p.q + (row_begin + row) * p.q_stride, p.q_stride, k, kBlock, block_stride,
               p.head_dim);
    for (int r = 0; r < kRows; ++r) {
      for (int v = 0; v < kVectors; ++v) {
        hn::Store(tile.v[r][v], d, p.scratch + (row + r) * padded_keys + column + v * kLanes);
      }
    }
  });
}

template <int kVectors>
HWY_INLINE void ValuesPanel(const Attention& p, int64_t row_begin, int64_t rows, int64_t column,
                            int64_t padded_keys, const float* inverse_sums) {
  const Tag d;
  const int64_t v_stride = BlocksOf(p.head_dim) * kBlock;
  ForRowTiles(0, rows, [&]<int kRows>(int64_t row) HWY_ATTR {
    Tile<kRows, kVectors> tile;
    InitTile(tile, nullptr);
    Accumulate(tile, p.scratch + row * padded_keys, padded_keys, p.v + column, v_stride, kBlock,
               p.keys);
    for (int r = 0; r < kRows; ++r) {
      alignas(64) float values[kVectors * kLanes];
      for (int v = 0; v < kVectors; ++v) {
        hn::Store(hn::Mul(tile.v[r][v], hn::Set(d, inverse_sums[row + r])), d, values + v * kLanes);
      }
      const int64_t count = std::min<int64_t>(kVectors * kLanes, p.head_dim - column);
      std::copy_n(values, std::max<int64_t>(count, 0),
                  p.out + (row_begin + row + r) * p.out_stride + column);
    }
  });
}

void FastAttention(const Attention& p) {
  constexpr int64_t kRowsAtOnce = kAttentionRows / kTileRows * kTileRows;
  const int64_t padded_keys = BlocksOf(p.keys) * kBlock;
  const int64_t padded_dim = BlocksOf(p.head_dim) * kBlock;
  for (int64_t row = p.row_begin; row < p.row_end; row += kRowsAtOnce) {
    const int64_t rows = std::min(kRowsAtOnce, p.row_end - row);
    int64_t column = 0;
    for (; column + kTileVectors * kLanes <= padded_keys; column += kTileVectors * kLanes) {
      ScoresPanel<kTileVectors>(p, row, rows, column, padded_keys);
    }
    for (; column < padded_keys; column += kLanes) {
      ScoresPanel<1>(p, row, rows, column, padded_keys);
    }
    float inverse_sums[kRowsAtOnce];
    for (int64_t r = 0; r < rows; ++r) {
      inverse_sums[r] = ExponentialsOfRow(p.scratch + r * padded_keys, p.keys);
    }
    column = 0;
    for (; column + kTileVectors * kLanes <= padded_dim; column += kTileVectors * kLanes) {
      ValuesPanel<kTileVectors>(p, row, rows, column, padded_keys, inverse_sums);
    }
    for (; column < padded_dim; column += kLanes) {
      ValuesPanel<1>(p, row, rows, column, padded_keys, inverse_sums);
    }
  }
}

}  // namespace gluevo::nn::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
