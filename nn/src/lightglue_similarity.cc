#include <algorithm>

#include "lightglue_network.h"

namespace gluevo::nn {

using kernels::BlocksOf;
using kernels::kBlock;

TensorView<float> LightGlueNetwork::Similarity(LightGlueState& state, Workspace& workspace) const {
  const Linear<float>& projection =
      layers_.layers[static_cast<std::size_t>(state.layers - 1)].final_projection;
  const LightGlueImage& image0 = state.images[0];
  const LightGlueImage& image1 = state.images[1];
  const int64_t blocks = BlocksOf(layers_.size);
  const Bands bands({image0.count, image1.count}, workspace.pool.size());
  const TensorView<float> scratch =
      workspace.arena.Allocate<float>({workspace.pool.size(), blocks * bands.most_rows() * kBlock});
  workspace.pool.ParallelFor(bands.size(), [&](int64_t index, int worker) {
    const Band band = bands[index];
    LightGlueImage& image = state.images[static_cast<std::size_t>(band.image)];
    float* const rows = scratch.data() + worker * scratch.extent(1);
    kernels::MatMul<float> product =
        Product(projection, image.tokens + band.begin * kBlock, image.stride, band.rows);
    product.c = band.image == 0 ? image.projected + band.begin * kBlock : rows;
    product.c_block_stride = band.image == 0 ? image.stride : band.rows * kBlock;
    kernels_->matmul(product);
    if (band.image == 1) {
      kernels::PackRows(rows, band.rows * kBlock, blocks, band.rows,
                        image.projected + band.begin * blocks * kBlock);
    }
  });

  const int64_t stride = BlocksOf(image1.count) * kBlock;
  const TensorView<float> scores = workspace.arena.Allocate<float>({image0.count, stride});
  constexpr int64_t kRows = 56;
  workspace.pool.ParallelFor((image0.count + kRows - 1) / kRows, [&](int64_t part, int /*worker*/) {
    const int64_t begin = part * kRows;
    // Padding columns are products with padding keys, which are zeros.
    kernels_->matmul({.a0 = image0.projected + begin * kBlock,
                      .a0_block_stride = image0.stride,
                      .a0_blocks = blocks,
                      .b = image1.projected,
                      .c = scores.data() + begin * stride,
                      .c_stride = stride,
                      .c_block_stride = kBlock,
                      .columns = stride,
                      .rows = std::min(kRows, image0.count - begin)});
  });
  return scores;
}

}  // namespace gluevo::nn
