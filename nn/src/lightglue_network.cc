#include "lightglue_network.h"

#include <algorithm>
#include <cmath>

namespace gluevo::nn {

using kernels::BlocksOf;
using kernels::kBlock;

/// Of one thread, for one band.
struct LightGlueNetwork::Scratch {
  float* scores;
  float* attended;  ///< Also keys on their way to their place.
  float* hidden;
};

LightGlueImage::LightGlueImage(const Features& features_in, const LightGlueLayers& layers,
                               Arena& arena)
    : features(&features_in), count(features_in.size()), stride(BlocksOf(count) * kBlock * kBlock) {
  const auto blocks = [&](int64_t number) {
    return arena.Allocate<float>({number, stride}).data();
  };
  const int64_t token_blocks = BlocksOf(layers.size);
  const int64_t head_blocks = layers.heads_size() / kBlock;
  tokens = blocks(token_blocks);
  cosines = blocks(layers.half_blocks);
  sines = blocks(layers.half_blocks);
  for (Keys& set : keys) {
    set = {blocks(head_blocks), blocks(head_blocks), blocks(head_blocks)};
  }
  logits = blocks(1);
  projected = blocks(token_blocks);
  indices = arena.Allocate<int32_t>({count}).data();
  rounds = arena.Allocate<int32_t>({count}).data();
  for (int64_t i = 0; i < count; ++i) {
    indices[i] = static_cast<int32_t>(i);
    rounds[i] = 1;
  }
}

void LightGlueNetwork::Encode(const Band& band, LightGlueImage& image,
                              const Scratch& scratch) const {
  const Features& features = *image.features;
  const int64_t band_stride = band.rows * kBlock;
  float* const tokens = image.tokens + band.begin * kBlock;
  const bool projects = layers_.input_projection.has_value();
  float* const to = projects ? scratch.hidden : tokens;
  const int64_t to_stride = projects ? band_stride : image.stride;
  for (int64_t block = 0; block < BlocksOf(layers_.descriptor_size); ++block) {
    const int64_t channels = std::min<int64_t>(kBlock, layers_.descriptor_size - block * kBlock);
    for (int64_t i = 0; i < band.rows; ++i) {
      float* const row = to + block * to_stride + i * kBlock;
      std::copy_n(&features.descriptors(band.begin + i, block * kBlock), channels, row);
      std::fill(row + channels, row + kBlock, 0.0F);
    }
  }
  if (projects) {
    kernels::MatMul<float> product = Product(*layers_.input_projection, to, to_stride, band.rows);
    product.c = tokens;
    product.c_block_stride = image.stride;
    kernels_->matmul(product);
  }

  const Eigen::Vector2d middle(features.width / 2.0, features.height / 2.0);
  const double scale = middle.maxCoeff();
  for (int64_t row = band.begin; row < band.begin + band.rows; ++row) {
    const Eigen::Vector2d position =
        (features.keypoints.row(row).transpose().cast<double>() - middle) / scale;
    for (int64_t j = 0; j < layers_.half_blocks * kBlock; ++j) {
      const double angle =
          j < layers_.position.rows() ? layers_.position.row(j).dot(position) : 0.0;
      const int64_t at = j / kBlock * image.stride + row * kBlock + j % kBlock;
      image.cosines[at] = std::cos(static_cast<float>(angle));
      image.sines[at] = std::sin(static_cast<float>(angle));
    }
  }
}

void LightGlueNetwork::StoreKeys(const Linear<float>& values, const Band& band,
                                 LightGlueImage& image, int set, const Scratch& scratch) const {
  const int64_t blocks = layers_.head_blocks();
  const int64_t band_stride = band.rows * kBlock;
  for (int64_t head = 0; head < layers_.heads; ++head) {
    kernels::PackRows(
        scratch.attended + head * blocks * band_stride, band_stride, blocks, band.rows,
        image.keys[set].k + head * blocks * image.stride + band.begin * blocks * kBlock);
  }
  float* const v = image.keys[set].v + band.begin * kBlock;
  kernels::MatMul<float> product =
      Product(values, image.tokens + band.begin * kBlock, image.stride, band.rows);
  product.c = v;
  product.c_block_stride = image.stride;
  kernels_->matmul(product);
  // Values of padding keys.
  const int64_t padded_rows = BlocksOf(band.rows) * kBlock;
  for (int64_t block = 0; block < layers_.heads * blocks; ++block) {
    std::fill(v + block * image.stride + band_stride,
              v + block * image.stride + padded_rows * kBlock, 0.0F);
  }
}

void LightGlueNetwork::ProjectSelf(const Layer& layer, const Band& band, LightGlueImage& image,
                                   const Scratch& scratch) const {
  const int64_t blocks = layers_.head_blocks();
  const auto project = [&](const Linear<float>& linear, float* out, int64_t block_stride) {
    kernels::MatMul<float> product =
        Product(linear, image.tokens + band.begin * kBlock, image.stride, band.rows);
    product.c = out;
    product.c_block_stride = block_stride;
    kernels_->matmul(product);
    for (int64_t head = 0; head < layers_.heads; ++head) {
      open_->rotate({.rows = out + head * blocks * block_stride,
                     .block_stride = block_stride,
                     .half_blocks = layers_.half_blocks,
                     .cosines = image.cosines + band.begin * kBlock,
                     .sines = image.sines + band.begin * kBlock,
                     .angle_block_stride = image.stride,
                     .count = band.rows});
    }
  };
  project(layer.q, image.keys[0].q + band.begin * kBlock, image.stride);
  project(layer.k, scratch.attended, band.rows * kBlock);
  StoreKeys(layer.v, band, image, 0, scratch);
}

void LightGlueNetwork::ProjectCross(const Layer& layer, const Band& band, LightGlueImage& image,
                                    const Scratch& scratch) const {
  const int64_t band_stride = band.rows * kBlock;
  kernels::MatMul<float> product =
      Product(layer.qk, image.tokens + band.begin * kBlock, image.stride, band.rows);
  product.c = scratch.attended;
  product.c_block_stride = band_stride;
  kernels_->matmul(product);
  for (int64_t block = 0; block < layers_.heads_size() / kBlock; ++block) {
    std::copy_n(scratch.attended + block * band_stride, band_stride,
                image.keys[1].q + block * image.stride + band.begin * kBlock);
  }
  StoreKeys(layer.cross_v, band, image, 1, scratch);
}

void LightGlueNetwork::Attend(const LightGlueLayers::Mlp& mlp, const Band& band,
                              LightGlueImage& image, const LightGlueImage& source, int set,
                              const Scratch& scratch) const {
  const int64_t blocks = layers_.head_blocks();
  const int64_t band_stride = band.rows * kBlock;
  for (int64_t head = 0; head < layers_.heads; ++head) {
    kernels_->attention(
        {.q = image.keys[set].q + head * blocks * image.stride + band.begin * kBlock,
         .q_block_stride = image.stride,
         .head_blocks = blocks,
         .k = source.keys[set].k + head * blocks * source.stride,
         .v = source.keys[set].v + head * blocks * source.stride,
         .v_block_stride = source.stride,
         .keys = source.count,
         .out = scratch.attended + head * blocks * band_stride,
         .out_block_stride = band_stride,
         .queries = band.rows,
         .scratch = scratch.scores});
  }
  float* const tokens = image.tokens + band.begin * kBlock;
  kernels::MatMul<float> first = Product(mlp.in, tokens, image.stride, band.rows);
  first.a1 = scratch.attended;
  first.a1_block_stride = band_stride;
  first.a1_blocks = mlp.in.blocks1;
  first.c = scratch.hidden;
  first.c_block_stride = band_stride;
  kernels_->matmul(first);
  open_->norm_gelu({.rows = scratch.hidden,
                    .block_stride = band_stride,
                    .channels = 2 * layers_.size,
                    .gain = mlp.gain.data(),
                    .shift = mlp.shift.data(),
                    .count = band.rows});
  kernels::MatMul<float> second = Product(mlp.out, scratch.hidden, band_stride, band.rows);
  second.residual = tokens;
  second.c = tokens;
  second.c_block_stride = image.stride;
  kernels_->matmul(second);
}

void LightGlueNetwork::Decide(const Layer& layer, const Band& band, LightGlueImage& image) const {
  kernels::MatMul<float> product =
      Product(layer.decisions, image.tokens + band.begin * kBlock, image.stride, band.rows);
  product.c = image.logits + band.begin * kBlock;
  kernels_->matmul(product);
}

LightGlueState LightGlueNetwork::Run(const Features& features0, const Features& features1,
                                     const LightGlueOptions& options, int64_t most_blocks,
                                     Workspace& workspace) const {
  Arena& arena = workspace.arena;
  const int64_t threads = workspace.pool.size();
  LightGlueState state{
      {LightGlueImage(features0, layers_, arena), LightGlueImage(features1, layers_, arena)}};
  const int64_t most_rows = Bands({features0.size(), features1.size()}, 1).most_rows();
  const TensorView<float> scores = arena.Allocate<float>(
      {threads, kernels::AttentionScratchFloats(std::max(features0.size(), features1.size()))});
  const TensorView<float> attended =
      arena.Allocate<float>({threads, layers_.heads_size() * most_rows});
  const TensorView<float> hidden = arena.Allocate<float>(
      {threads,
       most_rows * PaddedChannels<float>(std::max(2 * layers_.size, layers_.descriptor_size))});
  // Calls f(band, its image, the other image, scratch) for all that is left.
  const auto for_bands = [&](const auto& f) {
    const Bands bands({state.images[0].count, state.images[1].count}, static_cast<int>(threads));
    workspace.pool.ParallelFor(bands.size(), [&](int64_t index, int worker) {
      const Band band = bands[index];
      f(band, state.images[band.image], state.images[1 - band.image],
        Scratch{scores.data() + worker * scores.extent(1),
                attended.data() + worker * attended.extent(1),
                hidden.data() + worker * hidden.extent(1)});
    });
  };

  for_bands([&](const Band& band, LightGlueImage& image, const LightGlueImage& /*other*/,
                const Scratch& scratch) { Encode(band, image, scratch); });
  const auto layer_count = static_cast<int64_t>(layers_.layers.size());
  for (int64_t i = 0; 2 * i < most_blocks && i < layer_count; ++i) {
    const Layer& layer = layers_.layers[static_cast<std::size_t>(i)];
    for_bands([&](const Band& band, LightGlueImage& image, const LightGlueImage& /*other*/,
                  const Scratch& scratch) { ProjectSelf(layer, band, image, scratch); });
    for_bands([&](const Band& band, LightGlueImage& image, const LightGlueImage& /*other*/,
                  const Scratch& scratch) {
      Attend(layer.self_mlp, band, image, image, 0, scratch);
      ProjectCross(layer, band, image, scratch);
    });
    if (2 * i + 1 == most_blocks) {
      break;
    }
    for_bands([&](const Band& band, LightGlueImage& image, const LightGlueImage& other,
                  const Scratch& scratch) {
      Attend(layer.cross_mlp, band, image, other, 1, scratch);
      Decide(layer, band, image);
    });
    state.layers = i + 1;
    if (state.layers == layer_count ||
        (options.depth_confidence > 0.0F && StopsAfter(i, options, state))) {
      break;
    }
    if (options.width_confidence > 0.0F) {
      workspace.pool.ParallelFor(2, [&](int64_t image, int /*worker*/) {
        Prune(i, options, state.images[static_cast<std::size_t>(image)]);
      });
    }
    if (state.images[0].count == 0 || state.images[1].count == 0) {
      break;
    }
  }
  return state;
}

}  // namespace gluevo::nn
