// 3x3 convolution by Winograd's minimal filtering F(4x4, 3x3) (Lavin and Gray 2016): each 6x6 patch
// of the input becomes 36 values, in each of which the convolution is a product, and 4x4 outputs
// come back.

#if defined(GLUEVO_NN_KERNELS_WINOGRAD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_WINOGRAD_INL_H_
#undef GLUEVO_NN_KERNELS_WINOGRAD_INL_H_
#else
#define GLUEVO_NN_KERNELS_WINOGRAD_INL_H_
#endif

#include <algorithm>

#include "kernels/tile-inl.h"
#include "kernels/winograd.h"
#include "kernels/winograd_transforms-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

// Tiles that follow each other in a row of tiles.
struct TileRun {
  int64_t y = 0;  // First pixel.
  int64_t x = 0;
  int64_t tiles = 0;
};

// Tiles of the map that are transformed, multiplied and transformed back together.
struct TileBlock {
  TileRun runs[kWinogradTiles];
  int64_t count = 0;  // Runs.
  int64_t tiles = 0;

  void Add(int64_t y, int64_t x, int64_t more) {
    TileRun* const last = count > 0 ? runs + count - 1 : nullptr;
    if (last != nullptr && last->y == y && last->x + 4 * last->tiles == x) {
      last->tiles += more;
    } else {
      runs[count++] = {y, x, more};
    }
    tiles += more;
  }
};

// Floats from one of the 36 values to the next. An odd number of cache lines: the 36 lines that a
// tile writes or reads then lie in different sets of the first-level cache.
HWY_INLINE int64_t FrequencyStride(int64_t floats) { return ((floats + 15) / 16 | 1) * 16; }

// The run's part of the input with its surroundings, zeros where that leaves the map: what
// transforms read where the last tiles reach over the map's halo.
HWY_NOINLINE void CopyPatch(const BlockedMap& in, int64_t channel_block, const TileRun& run,
                            float* HWY_RESTRICT patch) {
  constexpr int64_t kHeight = 6;
  const int64_t width = 4 * run.tiles + 2;
  const int64_t rows = std::min(kHeight, in.height + 2 - run.y);
  const int64_t columns = std::min(width, in.width + 2 - run.x);
  for (int64_t y = 0; y < kHeight; ++y) {
    float* const to = patch + y * width * kBlock;
    const int64_t copied = y < rows ? columns * kBlock : 0;
    if (copied > 0) {
      std::copy_n(in.pixel(channel_block, run.y + y - 1, run.x - 1), copied, to);
    }
    std::fill(to + copied, to + width * kBlock, 0.0F);
  }
}

// v[value][channel block][tile][channel of the block].
HWY_NOINLINE void TransformBlock(const Conv3x3& p, const TileBlock& block, float* HWY_RESTRICT v,
                                 float* HWY_RESTRICT patch) {
  const int64_t v_stride = FrequencyStride(p.in.blocks * block.tiles * kBlock);
  float* to = v;
  for (int64_t channels = 0; channels < p.in.blocks; ++channels) {
    for (int64_t i = 0; i < block.count; ++i) {
      const TileRun& run = block.runs[i];
      const float* in = p.in.pixel(channels, run.y - 1, run.x - 1);
      int64_t row_stride = p.in.row_stride();
      if (run.y + 4 > p.in.height || run.x + 4 * run.tiles > p.in.width) {
        CopyPatch(p.in, channels, run, patch);
        in = patch;
        row_stride = (4 * run.tiles + 2) * kBlock;
      }
      for (int lane = 0; lane < kBlock; lane += kLanes) {
        TransformTileRow(in + lane, row_stride, run.tiles, to + lane, v_stride);
      }
      to += run.tiles * kBlock;
    }
  }
}

// m[value][tile][kVectors * kLanes] = the product of v and the weights of output channels that
// start at `channel`.
template <int kVectors>
HWY_NOINLINE void MultiplyBlock(const Conv3x3& p, const float* HWY_RESTRICT v, int64_t tiles,
                                int64_t channel, float* HWY_RESTRICT m) {
  const Tag d;
  constexpr int64_t kWidth = kVectors * kLanes;
  const int64_t v_stride = FrequencyStride(p.in.blocks * tiles * kBlock);
  const int64_t m_stride = FrequencyStride(tiles * kWidth);
  const int64_t value_stride = p.in.blocks * kBlock * kBlock;
  const int64_t weights_stride = 36 * value_stride;
  const float* weights = p.weights + channel / kBlock * weights_stride + channel % kBlock;
  for (int64_t value = 0; value < 36; ++value) {
    ForBalancedTiles(0, tiles, [&]<int kRows>(int64_t tile_index) HWY_ATTR {
      Tile<kRows, kVectors> tile;
      InitTile(tile, nullptr);
      AccumulateBlocks(tile, v + tile_index * kBlock, tiles * kBlock, p.in.blocks, weights,
                       weights_stride);
      float* const to = m + tile_index * kWidth;
      HWY_UNROLL(16)
      for (int r = 0; r < kRows; ++r) {
        HWY_UNROLL(16)
        for (int i = 0; i < kVectors; ++i) {
          hn::Store(tile.v[r][i], d, to + r * kWidth + i * kLanes);
        }
      }
    });
    v += v_stride;
    m += m_stride;
    weights += value_stride;
  }
}

// Transforms the products of output channels [channel, channel + kVectors * kLanes) back into the
// output map.
template <int kVectors>
HWY_NOINLINE void TransformBlockBack(const Conv3x3& p, const TileBlock& block, int64_t channel,
                                     const float* HWY_RESTRICT m) {
  const Tag d;
  const int64_t m_stride = FrequencyStride(block.tiles * kVectors * kLanes);
  // Of the outputs after pooling.
  const int64_t step = p.pool ? 2 : 4;
  const int64_t row_end = p.pool ? p.row_end / 2 : p.row_end;
  const int64_t column_end = p.pool ? p.column_end / 2 : p.column_end;
  for (int64_t run = 0; run < block.count; ++run) {
    const int64_t y = p.pool ? block.runs[run].y / 2 : block.runs[run].y;
    const int64_t x_begin = p.pool ? block.runs[run].x / 2 : block.runs[run].x;
    const int64_t rows = std::min(step, row_end - y);
    for (int64_t tile = 0; tile < block.runs[run].tiles; ++tile) {
      const int64_t x = x_begin + tile * step;
      const int64_t columns = std::min(step, column_end - x);
      for (int i = 0; i < kVectors; ++i) {
        const int64_t c = channel + i * kLanes;
        Vector out[4][4];
        TransformTileBack(p, m + i * kLanes, m_stride, c, out);
        if (p.pool) {
          HWY_UNROLL(2)
          for (int r = 0; r < 2; ++r) {
            HWY_UNROLL(2)
            for (int s = 0; s < 2; ++s) {
              out[r][s] = hn::Max(hn::Max(out[2 * r][2 * s], out[2 * r][2 * s + 1]),
                                  hn::Max(out[2 * r + 1][2 * s], out[2 * r + 1][2 * s + 1]));
            }
          }
        }
        float* to = p.out.pixel(c / kBlock, y, x) + c % kBlock;
        HWY_UNROLL(4)
        for (int r = 0; r < 4; ++r, to += p.out.row_stride()) {
          HWY_UNROLL(4)
          for (int s = 0; s < 4; ++s) {
            if (r < rows && s < columns) {
              hn::Store(out[r][s], d, to + s * kBlock);
            }
          }
        }
      }
      m += kVectors * kLanes;
    }
  }
}

HWY_NOINLINE void ConvolveBlock(const Conv3x3& p, const TileBlock& block) {
  const int64_t channels = p.out.blocks * kBlock;
  float* const v = p.scratch;
  float* const m = v + 36 * FrequencyStride(p.in.blocks * kWinogradTiles * kBlock);
  float* const patch = m + 36 * FrequencyStride(kWinogradTiles * kTileVectors * kLanes);
  TransformBlock(p, block, v, patch);
  int64_t channel = 0;
  for (; channel + kTileVectors * kLanes <= channels; channel += kTileVectors * kLanes) {
    MultiplyBlock<kTileVectors>(p, v, block.tiles, channel, m);
    TransformBlockBack<kTileVectors>(p, block, channel, m);
  }
  for (; channel < channels; channel += kLanes) {
    MultiplyBlock<1>(p, v, block.tiles, channel, m);
    TransformBlockBack<1>(p, block, channel, m);
  }
}

void FastWinogradConv3x3(const Conv3x3& p) {
  const int64_t tile_rows = (p.row_end - p.row_begin + 3) / 4;
  const int64_t tile_columns = (p.column_end - p.column_begin + 3) / 4;
  if (p.tiles != nullptr) {
    const int64_t parts = (p.tile_count + kWinogradTiles - 1) / kWinogradTiles;
    for (int64_t part = 0; part < parts; ++part) {
      TileBlock block;
      for (int64_t i = p.tile_count * part / parts; i < p.tile_count * (part + 1) / parts; ++i) {
        block.Add(p.row_begin + p.tiles[i] / tile_columns * 4,
                  p.column_begin + p.tiles[i] % tile_columns * 4, 1);
      }
      ConvolveBlock(p, block);
    }
    return;
  }
  const int64_t parts = (tile_columns + kWinogradColumns - 1) / kWinogradColumns;
  for (int64_t row = 0; row < tile_rows; row += kWinogradRows) {
    for (int64_t part = 0; part < parts; ++part) {
      const int64_t column = tile_columns * part / parts;
      TileBlock block;
      for (int64_t y = row; y < std::min(row + kWinogradRows, tile_rows); ++y) {
        block.Add(p.row_begin + 4 * y, p.column_begin + 4 * column,
                  tile_columns * (part + 1) / parts - column);
      }
      ConvolveBlock(p, block);
    }
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
