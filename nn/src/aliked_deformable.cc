// Deformable convolutions (Dai et al. 2017) of ALIKED's blocks 3 and 4.

#include <algorithm>

#include "aliked_buffers.h"
#include "aliked_network.h"

namespace gluevo::nn {

using kernels::BlockedMap;
using kernels::kBlock;

namespace {

// Pixels of a row whose sampled taps are multiplied together.
constexpr int64_t kDeformablePixels = 28;

}  // namespace

void AlikedNetwork::DeformableConvolution(int level, int conv, const BlockedMap& in,
                                          const BlockedMap& offsets, const BlockedMap& shortcut,
                                          const BlockedMap& out, Workspace& workspace) const {
  const AlikedLayers::Deformable& layer =
      layers_.deformable[static_cast<std::size_t>(level - 2)][static_cast<std::size_t>(conv)];
  const int64_t block_stride = kDeformablePixels * kBlock;
  const TensorView<float> rows =
      workspace.arena.Allocate<float>({workspace.pool.size(), 9 * in.blocks * block_stride});
  const float limit = static_cast<float>(std::max(in.height, in.width)) / 4.0F;
  const int64_t parts = (in.width + kDeformablePixels - 1) / kDeformablePixels;
  workspace.pool.ParallelFor(in.height * parts, [&](int64_t task, int worker) {
    const int64_t y = task / parts;
    const int64_t x = in.width * (task % parts) / parts;
    const int64_t x_end = in.width * (task % parts + 1) / parts;
    const int64_t count = x_end - x;
    kernels_->conv3x3({.in = in,
                       .weights = layer.offsets.weights.data(),
                       .bias = layer.offsets.bias.data(),
                       .out = offsets,
                       .row_begin = y,
                       .row_end = y + 1,
                       .column_begin = x,
                       .column_end = x_end});
    float* const operand = rows.data() + worker * rows.extent(1);
    open_->deformable_rows({.in = in,
                            .offsets = offsets,
                            .limit = limit,
                            .y = y,
                            .x_begin = x,
                            .count = count,
                            .rows = operand,
                            .block_stride = block_stride});
    kernels::MatMul<float> product = Product(layer.values, operand, block_stride, count);
    if (shortcut.data != nullptr) {
      product.a1 = shortcut.pixel(0, y, x);
      product.a1_block_stride = shortcut.block_stride();
      product.a1_blocks = layer.values.blocks1;
    }
    product.c = out.pixel(0, y, x);
    product.c_block_stride = out.block_stride();
    kernels_->matmul(product);
    SeluRegion(out, {y, y + 1, x, x_end});
  });
}

void AlikedNetwork::DeformableBlock(int level, const AlikedMaps& maps, const Buffers& buffers,
                                    Workspace& workspace) const {
  const auto at = static_cast<std::size_t>(level);
  const BlockedMap& in = buffers.pooled[at];
  const BlockedMap& inner = buffers.inner[at];
  const BlockedMap& out = maps.blocks[at];
  const BlockedMap second_offsets = NewMap(workspace.arena, 18, in.height, in.width);
  DeformableConvolution(level, 0, in, maps.offsets[at - 2], {}, inner, workspace);
  DeformableConvolution(level, 1, inner, second_offsets, in, out, workspace);
  workspace.pool.ParallelFor(out.height, [&](int64_t y, int worker) {
    ProjectRow(level, y, 0, out.width, maps, buffers.RowOf(worker));
  });
  if (level == 2) {
    const BlockedMap& pooled = buffers.pooled[3];
    open_->average_pool({.in = out,
                         .size = 4,
                         .out = pooled,
                         .row_end = pooled.height,
                         .column_end = pooled.width});
  }
}

}  // namespace gluevo::nn
