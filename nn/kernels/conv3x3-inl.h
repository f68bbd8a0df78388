// 3x3 convolution, direct: the tile slides along a row of pixels and sums over taps and channels.

#if defined(GLUEVO_NN_KERNELS_CONV3X3_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_CONV3X3_INL_H_
#undef GLUEVO_NN_KERNELS_CONV3X3_INL_H_
#else
#define GLUEVO_NN_KERNELS_CONV3X3_INL_H_
#endif

#include <algorithm>

#include "kernels/tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

// Pixels of a row that are computed for all output channels before the next ones: their inputs stay
// in the second-level cache meanwhile.
inline constexpr int64_t kSegment = 84;

// Computes pixels [x_begin, x_end) of row y before pooling, and output vectors that start at
// channel `channel`, into out[(x - x_begin) * kVectors * kLanes].
template <int kInBlock, int kVectors>
HWY_INLINE void ConvolveRow(const Conv3x3& p, int64_t y, int64_t x_begin, int64_t x_end,
                            int64_t channel, float* HWY_RESTRICT out, int64_t out_pixel_stride,
                            int64_t out_block_stride) {
  const Tag d;
  const int64_t row_stride = (p.in.width + 2) * kInBlock;
  const int64_t block_stride = (p.in.height + 2) * row_stride;
  const int64_t weights_stride = p.in.blocks * 9 * kInBlock * kBlock;
  const float* const weights = p.weights + channel / kBlock * weights_stride + channel % kBlock;
  const float* const in_row = p.in.data + y * row_stride;

  const auto tile_at = [&]<int kRows>(int64_t x) HWY_ATTR {
    Tile<kRows, kVectors> tile;
    InitTile(tile, p.bias + channel);
    const float* HWY_RESTRICT w = weights;
    for (int64_t block = 0; block < p.in.blocks; ++block) {
      for (int64_t ky = 0; ky < 3; ++ky) {
        const float* HWY_RESTRICT a =
            in_row + block * block_stride + ky * row_stride + x * kInBlock;
        for (int64_t kx = 0; kx < 3; ++kx, a += kInBlock, w += kInBlock * kBlock) {
          for (int c = 0; c < kInBlock; ++c) {
            AccumulateStep(tile, a + c, kInBlock, w + c * kBlock, weights_stride);
          }
        }
      }
    }
    if (p.relu) {
      Relu(tile);
    }
    if (p.scale != nullptr) {
      ScaleAndShift(tile, p.scale + channel, p.shift + channel);
    }
    float* const to = out + (x - x_begin) * out_pixel_stride;
    HWY_UNROLL(16)
    for (int r = 0; r < kRows; ++r) {
      HWY_UNROLL(16)
      for (int v = 0; v < kVectors; ++v) {
        hn::Store(tile.v[r][v], d, to + r * out_pixel_stride + VectorOffset(v, out_block_stride));
      }
    }
  };

  // A last, partial tile is moved back over pixels that are computed already: the same values.
  int64_t x = x_begin;
  for (; x + kTileRows <= x_end; x += kTileRows) {
    tile_at.template operator()<kTileRows>(x);
  }
  if (x < x_end && x_end - kTileRows >= x_begin) {
    tile_at.template operator()<kTileRows>(x_end - kTileRows);
  } else {
    for (; x < x_end; ++x) {
      tile_at.template operator()<1>(x);
    }
  }
}

// One row of one segment of pixels, or two that are pooled to one, and `kVectors` vectors of
// channels.
template <int kInBlock, int kVectors>
HWY_NOINLINE void ConvolveSegment(const Conv3x3& p, int64_t y, int64_t x_begin, int64_t x_end,
                                  int64_t channel) {
  const Tag d;
  const int64_t out_block = channel / kBlock;
  if (!p.pool) {
    ConvolveRow<kInBlock, kVectors>(p, y, x_begin, x_end, channel,
                                    p.out.pixel(out_block, y, x_begin) + channel % kBlock, kBlock,
                                    p.out.block_stride());
    return;
  }
  // Even for the widest vectors this stays in the first-level cache.
  constexpr int64_t kPixel = kVectors * kLanes;
  alignas(64) float rows[2][kSegment * kPixel];
  for (int64_t i = 0; i < 2; ++i) {
    ConvolveRow<kInBlock, kVectors>(p, y + i, x_begin, x_end, channel, rows[i], kPixel, kBlock);
  }
  for (int64_t x = 0; x + 1 < x_end - x_begin; x += 2) {
    float* const to = p.out.pixel(out_block, y / 2, (x_begin + x) / 2) + channel % kBlock;
    for (int v = 0; v < kVectors; ++v) {
      const int64_t at = x * kPixel + v * kLanes;
      const Vector top = hn::Max(hn::Load(d, rows[0] + at), hn::Load(d, rows[0] + at + kPixel));
      const Vector bottom = hn::Max(hn::Load(d, rows[1] + at), hn::Load(d, rows[1] + at + kPixel));
      hn::Store(hn::Max(top, bottom), d, to + VectorOffset(v, p.out.block_stride()));
    }
  }
}

template <int kInBlock>
HWY_INLINE void ConvolveRows(const Conv3x3& p) {
  const int64_t step = p.pool ? 2 : 1;
  const int64_t width = (p.column_end - p.column_begin) / step * step;
  const int64_t channels = p.out.blocks * kBlock;
  const int64_t segments = (width + kSegment - 1) / kSegment;
  for (int64_t segment = 0; segment < segments; ++segment) {
    // Of even length, so that pooling pairs stay together.
    const int64_t x_begin = p.column_begin + width * segment / segments / 2 * 2;
    const int64_t x_end =
        p.column_begin +
        (segment + 1 == segments ? width : width * (segment + 1) / segments / 2 * 2);
    for (int64_t y = p.row_begin; y + step <= p.row_end; y += step) {
      int64_t channel = 0;
      for (; channel + kTileVectors * kLanes <= channels; channel += kTileVectors * kLanes) {
        ConvolveSegment<kInBlock, kTileVectors>(p, y, x_begin, x_end, channel);
      }
      for (; channel < channels; channel += kLanes) {
        ConvolveSegment<kInBlock, 1>(p, y, x_begin, x_end, channel);
      }
    }
  }
}

void FastConv3x3(const Conv3x3& p) {
  if (p.gray) {
    ConvolveRows<1>(p);
  } else {
    ConvolveRows<kBlock>(p);
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
