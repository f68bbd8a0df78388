// The register tile that convolution, matrix product and attention share: kTileRows rows (pixels,
// tokens or queries) by kTileVectors vectors of output channels, accumulated in registers.

#if defined(GLUEVO_NN_KERNELS_TILE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_TILE_INL_H_
#undef GLUEVO_NN_KERNELS_TILE_INL_H_
#else
#define GLUEVO_NN_KERNELS_TILE_INL_H_
#endif

#include <hwy/highway.h>

#include "kernels/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, kBlock>;
using Vector = hn::Vec<Tag>;
inline constexpr int kLanes = static_cast<int>(hn::MaxLanes(Tag()));

// As many accumulators as the register file holds beside the weights and one broadcast: 32
// registers with AVX-512 and NEON, 16 with SSE and AVX2.
#if HWY_TARGET <= HWY_AVX3
inline constexpr int kTileRows = 14;
inline constexpr int kTileVectors = 2;
#elif HWY_TARGET == HWY_NEON
inline constexpr int kTileRows = 6;
inline constexpr int kTileVectors = 4;
#elif HWY_TARGET == HWY_SCALAR
inline constexpr int kTileRows = 2;
inline constexpr int kTileVectors = 4;
#else
inline constexpr int kTileRows = 6;
inline constexpr int kTileVectors = 2;
#endif

template <int kRows, int kVectors>
struct Tile {
  Vector v[kRows][kVectors];
};

// A packed operand stores blocks of kBlock columns `block_stride` floats apart; this is where
// vector v of a tile that starts at a block (or inside one) lies.
HWY_INLINE int64_t VectorOffset(int v, int64_t block_stride) {
  const int lane = v * kLanes;
  return lane / kBlock * block_stride + lane % kBlock;
}

template <int kRows, int kVectors>
HWY_INLINE void InitTile(Tile<kRows, kVectors>& tile, const float* HWY_RESTRICT bias) {
  const Tag d;
  HWY_UNROLL(16)
  for (int v = 0; v < kVectors; ++v) {
    const Vector value = bias != nullptr ? hn::Load(d, bias + v * kLanes) : hn::Zero(d);
    HWY_UNROLL(16)
    for (int r = 0; r < kRows; ++r) {
      tile.v[r][v] = value;
    }
  }
}

// tile += a b for one step of depth: a[r * a_stride] is broadcast, kVectors vectors of b loaded.
template <int kRows, int kVectors>
HWY_INLINE void AccumulateStep(Tile<kRows, kVectors>& tile, const float* HWY_RESTRICT a,
                               int64_t a_stride, const float* HWY_RESTRICT b,
                               int64_t b_block_stride) {
  const Tag d;
  Vector w[kVectors];
  HWY_UNROLL(16)
  for (int v = 0; v < kVectors; ++v) {
    w[v] = hn::Load(d, b + VectorOffset(v, b_block_stride));
  }
  HWY_UNROLL(16)
  for (int r = 0; r < kRows; ++r) {
    const Vector x = hn::Set(d, a[r * a_stride]);
    HWY_UNROLL(16)
    for (int v = 0; v < kVectors; ++v) {
      tile.v[r][v] = hn::MulAdd(x, w[v], tile.v[r][v]);
    }
  }
}

// tile += a b over `depth` steps; the rows of b are b_stride floats apart. The loop is not
// unrolled: with several steps in one body g++ 12 spills accumulators (65 % of the peak instead of
// 95 %).
template <int kRows, int kVectors>
HWY_INLINE void Accumulate(Tile<kRows, kVectors>& tile, const float* HWY_RESTRICT a,
                           int64_t a_stride, const float* HWY_RESTRICT b, int64_t b_stride,
                           int64_t b_block_stride, int64_t depth) {
  for (int64_t k = 0; k < depth; ++k) {
    AccumulateStep(tile, a + k, a_stride, b + k * b_stride, b_block_stride);
  }
}

template <int kRows, int kVectors>
HWY_INLINE void Relu(Tile<kRows, kVectors>& tile) {
  const Vector zero = hn::Zero(Tag());
  HWY_UNROLL(16)
  for (int r = 0; r < kRows; ++r) {
    HWY_UNROLL(16)
    for (int v = 0; v < kVectors; ++v) {
      tile.v[r][v] = hn::Max(tile.v[r][v], zero);
    }
  }
}

template <int kRows, int kVectors>
HWY_INLINE void ScaleAndShift(Tile<kRows, kVectors>& tile, const float* HWY_RESTRICT scale,
                              const float* HWY_RESTRICT shift) {
  const Tag d;
  for (int v = 0; v < kVectors; ++v) {
    const Vector factor = hn::Load(d, scale + v * kLanes);
    const Vector offset = hn::Load(d, shift + v * kLanes);
    HWY_UNROLL(16)
    for (int r = 0; r < kRows; ++r) {
      tile.v[r][v] = hn::MulAdd(tile.v[r][v], factor, offset);
    }
  }
}

// Calls f.template operator()<kRows>(row) for tiles of kTileRows rows, then of half as many, and so
// on, until [begin, end) is covered once.
template <int kRows = kTileRows, typename F>
HWY_INLINE void ForRowTiles(int64_t begin, int64_t end, const F& f) {
  for (; begin + kRows <= end; begin += kRows) {
    f.template operator()<kRows>(begin);
  }
  if constexpr (kRows > 1) {
    ForRowTiles<kRows / 2>(begin, end, f);
  }
}

template <int kMost, typename F>
HWY_INLINE void CallWithRows(int64_t rows, int64_t begin, const F& f) {
  if (rows == kMost) {
    f.template operator()<kMost>(begin);
  } else if constexpr (kMost > 1) {
    CallWithRows<kMost - 1>(rows, begin, f);
  }
}

// Calls f.template operator()<rows>(row) for the fewest tiles that cover [begin, end), all of about
// the same height: a tile of a few rows waits for its multiply-adds.
template <typename F>
HWY_INLINE void ForBalancedTiles(int64_t begin, int64_t end, const F& f) {
  const int64_t count = end - begin;
  const int64_t parts = (count + kTileRows - 1) / kTileRows;
  for (int64_t part = 0; part < parts; ++part) {
    const int64_t first = count * part / parts;
    CallWithRows<kTileRows>(count * (part + 1) / parts - first, begin + first, f);
  }
}

}  // namespace gluevo::nn::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
