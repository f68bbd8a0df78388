#include <algorithm>
#include <cmath>

#include "aliked_buffers.h"
#include "aliked_network.h"
#include "kernels/winograd.h"
#include "map_regions.h"

namespace gluevo::nn {

using kernels::BlockedMap;
using kernels::BlocksOf;
using kernels::kBlock;

namespace {

constexpr int64_t kMultiple = 32;  // Of the padded sides.
constexpr int64_t kScales[] = {1, 2, 8, 32};

kernels::AlignedTap* AlignedTaps(Arena& arena, int64_t from, int64_t to) {
  kernels::AlignedTap* const taps = arena.Allocate<kernels::AlignedTap>({to}).data();
  for (int64_t i = 0; i < to; ++i) {
    const double at = to > 1 ? static_cast<double>(i) * static_cast<double>(from - 1) /
                                   static_cast<double>(to - 1)
                             : 0.0;
    const auto low = static_cast<int32_t>(at);
    taps[i] = {low, std::min(low + 1, static_cast<int32_t>(from) - 1),
               static_cast<float>(at - low)};
  }
  return taps;
}

// The image as floats 0 to 1, its border pixels repeated up to the padded size, with a halo of
// zeros: [padded_height + 2][padded_width + 2].
float* GrayPlane(const GrayImage& image, const AlikedMaps& maps, Workspace& workspace) {
  const int64_t stride = maps.padded_width + 2;
  const TensorView<float> plane = workspace.arena.Allocate<float>({maps.padded_height + 2, stride});
  plane.Matrix().row(0).setZero();
  plane.Matrix().row(maps.padded_height + 1).setZero();
  workspace.pool.ParallelFor(maps.padded_height / kMultiple, [&](int64_t band, int /*worker*/) {
    for (int64_t y = band * kMultiple; y < (band + 1) * kMultiple; ++y) {
      float* const to = plane.data() + (y + 1) * stride + 1;
      const uint8_t* const from =
          image.data + std::clamp<int64_t>(y - maps.top, 0, maps.height - 1) * image.stride;
      const auto value = [&](int64_t x) { return static_cast<float>(from[x]) / 255.0F; };
      for (int64_t x = 0; x < maps.width; ++x) {
        to[maps.left + x] = value(x);
      }
      std::fill(to, to + maps.left, value(0));
      std::fill(to + maps.left + maps.width, to + maps.padded_width, value(maps.width - 1));
      to[-1] = 0.0F;
      to[maps.padded_width] = 0.0F;
    }
  });
  return plane.data();
}

}  // namespace

void AlikedNetwork::SeluRegion(const BlockedMap& map, const Region& region) const {
  for (int64_t block = 0; block < map.blocks; ++block) {
    for (int64_t y = region.row; y < region.row_end; ++y) {
      open_->selu({.values = map.pixel(block, y, region.column), .count = region.width() * kBlock});
    }
  }
}

void AlikedNetwork::ProjectRow(int level, int64_t y, int64_t x, int64_t count,
                               const AlikedMaps& maps, float* scratch) const {
  const auto at = static_cast<std::size_t>(level);
  const BlockedMap& block = maps.blocks[at];
  const BlockedMap& features = maps.features[at];
  const bool keeps = features.data != nullptr;
  float* const rows = keeps ? features.pixel(0, y, x) : scratch;
  const int64_t stride = keeps ? features.block_stride() : count * kBlock;
  kernels::MatMul<float> product =
      Product(layers_.projections[at], block.pixel(0, y, x), block.block_stride(), count);
  product.c = rows;
  product.c_block_stride = stride;
  kernels_->matmul(product);
  for (int64_t i = 0; i < layers_.size / 4 / kBlock; ++i) {
    open_->selu({.values = rows + i * stride, .count = count * kBlock});
  }
  if (maps.fine_scores.data() == nullptr) {
    return;
  }
  product = Product(layers_.score_groups[at], rows, stride, count);
  product.c = level == 0 ? scratch + layers_.size / 4 * count : maps.scores[at].pixel(0, y, x);
  kernels_->matmul(product);
  if (level == 0) {
    const int64_t channels = maps.fine_scores.extent(2);
    float* to = maps.fine_scores.data() + (y * maps.padded_width + x) * channels;
    for (int64_t i = 0; i < count; ++i, to += channels) {
      for (int64_t c = 0; c < channels; c += kernels::kScoreGroup) {
        std::copy_n(product.c + i * kBlock + c, kernels::kScoreGroup, to + c);
      }
    }
  }
}

// Each region of the first convolution, with its neighbours, goes straight through the second one,
// which is what is kept of it.
void AlikedNetwork::Block1(float* gray, const AlikedMaps& maps, const Buffers& buffers,
                           Workspace& workspace) const {
  const BlockedMap& out = maps.blocks[0];
  const int64_t width = out.width;
  const int64_t height = out.height;
  ForRegions(
      workspace.pool, height, width,
      [&](int64_t row, int64_t row_end, int64_t column, int64_t column_end, int worker) {
        const BlockedMap inner{buffers.RegionOf(worker), BlocksOf(layers_.widths[0]), row_end - row,
                               column_end - column};
        const bool left = column == 0;
        const bool right = column_end == width;
        const bool top = row == 0;
        const bool bottom = row_end == height;
        if (left || right || top || bottom) {
          kernels::ClearHalo(inner);
        }
        layers_.block1_conv1.kernel({.in = {gray + row * (width + 2) + column, 1, height, width},
                                     .gray = true,
                                     .weights = layers_.block1_conv1.weights.data(),
                                     .bias = layers_.block1_conv1.bias.data(),
                                     .out = inner,
                                     .row_begin = top ? 0 : -1,
                                     .row_end = inner.height + (bottom ? 0 : 1),
                                     .column_begin = left ? 0 : -1,
                                     .column_end = inner.width + (right ? 0 : 1)});
        // The halo's zeros stay zeros.
        open_->selu({.values = inner.data,
                     .count = BlockedMap::Floats(inner.blocks, inner.height, inner.width)});
        BlockedMap to = out;
        to.data += row * out.row_stride() + column * kBlock;
        layers_.block1_conv2.kernel({.in = inner,
                                     .weights = layers_.block1_conv2.weights.data(),
                                     .bias = layers_.block1_conv2.bias.data(),
                                     .out = to,
                                     .row_end = inner.height,
                                     .column_end = inner.width,
                                     .scratch = buffers.WinogradOf(worker)});
        SeluRegion(out, {row, row_end, column, column_end});
        open_->average_pool({.in = out,
                             .size = 2,
                             .out = buffers.pooled[1],
                             .row_begin = row / 2,
                             .row_end = row_end / 2,
                             .column_begin = column / 2,
                             .column_end = column_end / 2});
        if (maps.fine_scores.data() != nullptr) {
          for (int64_t y = row; y < row_end; ++y) {
            ProjectRow(0, y, column, column_end - column, maps, buffers.RowOf(worker));
          }
        }
      });
}

void AlikedNetwork::Block2(const AlikedMaps& maps, const Buffers& buffers,
                           Workspace& workspace) const {
  const BlockedMap& in = buffers.pooled[1];
  const BlockedMap& inner = buffers.inner[1];
  const BlockedMap& out = maps.blocks[1];
  const auto convolve = [&](const AlikedLayers::Convolution& layer, const BlockedMap& from,
                            const BlockedMap& to, const Region& region, int worker) {
    layer.kernel({.in = from,
                  .weights = layer.weights.data(),
                  .bias = layer.bias.data(),
                  .out = to,
                  .row_begin = region.row,
                  .row_end = region.row_end,
                  .column_begin = region.column,
                  .column_end = region.column_end,
                  .scratch = buffers.WinogradOf(worker)});
  };
  ForRegions(
      workspace.pool, in.height, in.width,
      [&](int64_t row, int64_t row_end, int64_t column, int64_t column_end, int worker) {
        convolve(layers_.block2_conv1, in, inner, {row, row_end, column, column_end}, worker);
        SeluRegion(inner, {row, row_end, column, column_end});
      });
  ForRegions(
      workspace.pool, in.height, in.width,
      [&](int64_t row, int64_t row_end, int64_t column, int64_t column_end, int worker) {
        convolve(layers_.block2_conv2, inner, out, {row, row_end, column, column_end}, worker);
        for (int64_t y = row; y < row_end; ++y) {
          kernels::MatMul<float> shortcut =
              Product(layers_.block2_downsample, in.pixel(0, y, column), in.block_stride(),
                      column_end - column);
          shortcut.residual = out.pixel(0, y, column);
          shortcut.c = out.pixel(0, y, column);
          shortcut.c_block_stride = out.block_stride();
          kernels_->matmul(shortcut);
        }
        SeluRegion(out, {row, row_end, column, column_end});
        open_->average_pool({.in = out,
                             .size = 4,
                             .out = buffers.pooled[2],
                             .row_begin = row / 4,
                             .row_end = row_end / 4,
                             .column_begin = column / 4,
                             .column_end = column_end / 4});
        for (int64_t y = row; y < row_end; ++y) {
          ProjectRow(1, y, column, column_end - column, maps, buffers.RowOf(worker));
        }
      });
}

AlikedMaps AlikedNetwork::Encode(const GrayImage& image, bool with_scores,
                                 Workspace& workspace) const {
  Arena& arena = workspace.arena;
  AlikedMaps maps;
  maps.width = image.width;
  maps.height = image.height;
  const auto padded = [](int64_t side) { return (side + kMultiple - 1) / kMultiple * kMultiple; };
  maps.padded_width = padded(image.width);
  maps.padded_height = padded(image.height);
  maps.left = (maps.padded_width - image.width) / 2;
  maps.top = (maps.padded_height - image.height) / 2;
  if (with_scores) {
    maps.fine_scores = arena.Allocate<float>(
        {maps.padded_height, maps.padded_width, kernels::ScoreStride(layers_.score_channels)});
  }
  Buffers buffers;
  for (std::size_t i = 0; i < 4; ++i) {
    const int64_t height = maps.padded_height / kScales[i];
    const int64_t width = maps.padded_width / kScales[i];
    maps.blocks[i] = NewMap(arena, layers_.widths[i], height, width);
    if (i == 0) {
      continue;
    }
    if (with_scores) {
      maps.scores[i] = NewMap(arena, layers_.score_channels, height, width);
    }
    maps.features[i] = NewMap(arena, layers_.size / 4, height, width);
    maps.taps_y[i - 1] = AlignedTaps(arena, height, maps.padded_height);
    maps.taps_x[i - 1] = AlignedTaps(arena, width, maps.padded_width);
    buffers.pooled[i] = NewMap(arena, layers_.widths[i - 1], height, width);
    buffers.inner[i] = NewMap(arena, layers_.widths[i], height, width);
    kernels::ClearHalo(buffers.pooled[i]);
    kernels::ClearHalo(buffers.inner[i]);
    if (i >= 2) {
      maps.offsets[i - 2] = NewMap(arena, 18, height, width);
    }
  }
  constexpr int64_t kRegionColumns = 56;
  buffers.region = arena.Allocate<float>(
      {workspace.pool.size(), BlockedMap::Floats(BlocksOf(layers_.widths[0]), 8, kRegionColumns)});
  buffers.row =
      arena.Allocate<float>({workspace.pool.size(), (layers_.size / 4 + kBlock) * kRegionColumns});
  buffers.winograd = arena.Allocate<float>(
      {workspace.pool.size(),
       kernels::WinogradScratchFloats(std::max(layers_.widths[0], layers_.widths[1]))});

  Block1(GrayPlane(image, maps, workspace), maps, buffers, workspace);
  Block2(maps, buffers, workspace);
  DeformableBlock(2, maps, buffers, workspace);
  DeformableBlock(3, maps, buffers, workspace);
  return maps;
}

}  // namespace gluevo::nn
