#include "graph_network.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include "graph_network_buffers.h"

namespace gluevo::nn {
namespace {

using kernels::BlocksOf;
using kernels::ElementBlocks;
using kernels::kBlock;
using kernels::kChannelsPer;

// Where a product's result goes, as the left operand of another one.
void SetOutput(float* out, int64_t block_stride, kernels::MatMul<float>& product) {
  product.c = out;
  product.c_block_stride = block_stride;
}
void SetOutput(kernels::Bf16Pair* out, int64_t block_stride,
               kernels::MatMul<kernels::Bf16Pair>& product) {
  product.rounded = out;
  product.rounded_block_stride = block_stride;
}

}  // namespace

template <typename Element>
void GraphNetwork<Element>::Encode(const Features& features, const Band& band, Image& image,
                                   Scratch& scratch) const {
  const int64_t stride = band.rows * kBlock;
  const auto width = static_cast<float>(features.width);
  const auto height = static_cast<float>(features.height);
  const float scale = 0.7F * std::max(width, height);
  float* const inputs = scratch.encoder[0];
  std::fill_n(inputs, stride, 0.0F);
  for (int64_t i = 0; i < band.rows; ++i) {
    const int64_t row = band.begin + i;
    inputs[i * kBlock] = (features.keypoints(row, 0) - width / 2.0F) / scale;
    inputs[i * kBlock + 1] = (features.keypoints(row, 1) - height / 2.0F) / scale;
    inputs[i * kBlock + 2] = features.scores[row];
    for (int64_t block = 0; block < BlocksOf(weights_.size); ++block) {
      float* const token = image.tokens + block * image.stride + row * kBlock;
      const int64_t channels = std::min<int64_t>(kBlock, weights_.size - block * kBlock);
      std::copy_n(&features.descriptors(row, block * kBlock), channels, token);
      std::fill(token + channels, token + kBlock, 0.0F);
    }
  }
  for (std::size_t i = 0; i < weights_.encoder.size(); ++i) {
    kernels::MatMul<float> product =
        Product<float>(weights_.encoder[i], scratch.encoder[i % 2], stride, band.rows);
    if (i + 1 < weights_.encoder.size()) {
      product.relu = true;
      SetOutput(scratch.encoder[(i + 1) % 2], stride, product);
    } else {
      product.residual = image.tokens + band.begin * kBlock;
      SetOutput(image.tokens + band.begin * kBlock, image.stride, product);
      if constexpr (!std::is_same_v<Element, float>) {
        product.rounded = image.operands + band.begin * kBlock;
        product.rounded_block_stride = image.stride;
      }
    }
    kernels_->matmul(product);
  }
}

template <typename Element>
void GraphNetwork<Element>::Project(const Layer& layer, const Band& band, Image& image, int key_set,
                                    Scratch& scratch) const {
  const Element* const rows = image.operands + band.begin * kBlock;
  const auto multiply = [&](const Linear<Element>& linear, Element* out, int64_t block_stride) {
    kernels::MatMul<Element> product = Product(linear, rows, image.stride, band.rows);
    SetOutput(out, block_stride, product);
    kernels::Multiply(*kernels_, product);
  };
  const int64_t blocks = ElementBlocks<Element>(weights_.head_size);
  const int64_t head_elements = blocks * image.stride;
  const int64_t band_stride = band.rows * kBlock;

  multiply(layer.q, image.q + band.begin * kBlock, image.stride);
  multiply(layer.k, scratch.attended, band_stride);
  for (int64_t head = 0; head < weights_.heads; ++head) {
    kernels::PackRows(scratch.attended + head * blocks * band_stride, band_stride, blocks,
                      band.rows,
                      image.k[key_set] + head * head_elements + band.begin * blocks * kBlock);
  }
  if constexpr (std::is_same_v<Element, float>) {
    multiply(layer.v, image.v[key_set] + band.begin * kBlock, image.stride);
  } else {
    multiply(layer.v, scratch.attended, band_stride);
    kernels::PackValues(scratch.attended, band_stride, weights_.heads * blocks, band.rows,
                        image.v[key_set] + band.begin / 2 * kBlock, image.stride / 2);
  }
}

template <typename Element>
void GraphNetwork<Element>::RunLayer(const Layer& layer, const Band& band, Image& image,
                                     const Image& source, int key_set, Scratch& scratch) const {
  const int64_t blocks = ElementBlocks<Element>(weights_.head_size);
  const int64_t band_stride = band.rows * kBlock;
  for (int64_t head = 0; head < weights_.heads; ++head) {
    kernels::Attend<Element>(*kernels_,
                             {.q = image.q + head * blocks * image.stride + band.begin * kBlock,
                              .q_block_stride = image.stride,
                              .head_blocks = blocks,
                              .k = source.k[key_set] + head * blocks * source.stride,
                              .v = source.v[key_set] + head * blocks * source.stride,
                              .v_block_stride = source.stride / kChannelsPer<Element>,
                              .keys = source.count,
                              .out = scratch.attended + head * blocks * band_stride,
                              .out_block_stride = band_stride,
                              .queries = band.rows,
                              .scratch = scratch.scores});
  }

  kernels::MatMul<Element> first =
      Product(layer.mlp_in, image.operands + band.begin * kBlock, image.stride, band.rows);
  first.a1 = scratch.attended;
  first.a1_block_stride = band_stride;
  first.a1_blocks = layer.mlp_in.blocks1;
  first.relu = true;
  SetOutput(scratch.hidden, band_stride, first);
  kernels::Multiply(*kernels_, first);

  kernels::MatMul<Element> second =
      Product<Element>(layer.mlp_out, scratch.hidden, band_stride, band.rows);
  second.residual = image.tokens + band.begin * kBlock;
  second.columns = BlocksOf(weights_.size) * kBlock;
  second.c = image.tokens + band.begin * kBlock;
  second.c_block_stride = image.stride;
  if constexpr (!std::is_same_v<Element, float>) {
    SetOutput(image.operands + band.begin * kBlock, image.stride, second);
  }
  kernels::Multiply(*kernels_, second);
}

template <typename Element>
void GraphNetwork<Element>::ProjectLast(const Band& band, Image& image, Scratch& scratch) const {
  kernels::MatMul<Element> product = Product(
      weights_.final_projection, image.operands + band.begin * kBlock, image.stride, band.rows);
  // Of image 0 to its place, of image 1 to be packed.
  float* const rows = scratch.encoder[0];
  product.c = band.image == 0 ? image.projected + band.begin * kBlock : rows;
  product.c_block_stride = band.image == 0 ? image.stride : band.rows * kBlock;
  kernels::Multiply(*kernels_, product);
  if (band.image == 1) {
    kernels::PackRows(rows, band.rows * kBlock, BlocksOf(weights_.size), band.rows,
                      image.projected + band.begin * BlocksOf(weights_.size) * kBlock);
  }
}

template <typename Element>
void GraphNetwork<Element>::RunStep(int64_t step, int64_t index, Shared& shared,
                                    Scratch& scratch) const {
  const auto layers = static_cast<int64_t>(weights_.layers.size());
  const auto is_cross = [](int64_t layer) { return layer % 2 == 1; };
  const Band band = shared.bands[index];
  Image& image = shared.images[band.image];
  StepProgress& progress = shared.progress;
  if (step == 0) {
    Encode(*shared.features[band.image], band, image, scratch);
  } else {
    progress.WaitForBand(step - 1, index);
  }
  if (step > 0 && step <= layers) {
    const int source = is_cross(step - 1) ? 1 - band.image : band.image;
    progress.WaitForImage(step - 1, source);
    RunLayer(weights_.layers[step - 1], band, image, shared.images[source],
             static_cast<int>((step - 1) % Image::kKeySets), scratch);
  }
  if (step < layers) {
    if (step >= 2) {  // Its keys and values are overwritten.
      progress.WaitForImage(step - 2, 0);
      progress.WaitForImage(step - 2, 1);
    }
    Project(weights_.layers[step], band, image, static_cast<int>(step % Image::kKeySets), scratch);
  }
  if (step == layers + 1) {
    ProjectLast(band, image, scratch);
  }
  progress.Pass(step, band.image, index);
}

template <typename Element>
Projected GraphNetwork<Element>::Run(const Features& features0, const Features& features1,
                                     Workspace& workspace) const {
  const int64_t steps = static_cast<int64_t>(weights_.layers.size()) + 2;
  Shared shared(features0, features1, weights_, steps, workspace);
  const int64_t bands = shared.bands.size();
  workspace.pool.ParallelFor(steps * bands, [&](int64_t task, int worker) {
    const int64_t step = task / bands;
    // First in a step is the image that attends to keys and values which are all there while the
    // last bands of the step before are still at work: from one layer of cross-attention to the
    // next the images take turns.
    const int64_t cross_layers = step / 2;  // So far.
    const int64_t index = shared.bands.InTurn(task % bands, cross_layers % 2 == 1);
    Scratch scratch = shared.ScratchOf(worker);
    RunStep(step, index, shared, scratch);
  });
  const std::array<Image, 2>& images = shared.images;
  return {images[0].projected, images[0].stride, BlocksOf(weights_.size), images[1].projected};
}

template class GraphNetwork<float>;
template class GraphNetwork<kernels::Bf16Pair>;

}  // namespace gluevo::nn
