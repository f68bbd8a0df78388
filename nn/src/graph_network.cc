#include "graph_network.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include "step_progress.h"

namespace gluevo::nn {
namespace {

using kernels::BlocksOf;
using kernels::ElementBlocks;
using kernels::kBlock;
using kernels::kChannelsPer;

// Rows that pass through a layer together: the more, the less often a layer's weights are read; the
// fewer, the closer are the rows' hidden values.
constexpr int64_t kMostBandRows = 3 * kBlock;

// Layers whose keys and values are kept: of one that the last bands are still at, of the next,
// which others have begun, and of the one after that, which these write.
constexpr int kKeySets = 3;

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

// Rows [begin, begin + rows) of one image, begin a multiple of kBlock.
template <typename Element>
struct GraphNetwork<Element>::Band {
  int image = 0;
  int64_t begin = 0;
  int64_t rows = 0;
};

template <typename Element>
struct GraphNetwork<Element>::Image {
  Image(int64_t count_in, int64_t size, int64_t heads_size, Arena& arena)
      : count(count_in), rows(PaddedChannels<Element>(count_in)), stride(rows * kBlock) {
    const int64_t floats = BlocksOf(size) * stride;
    const int64_t elements = heads_size / kChannelsPer<Element> * rows;
    tokens = arena.Allocate<float>({floats}).data();
    if constexpr (std::is_same_v<Element, float>) {
      operands = tokens;
    } else {
      const int64_t operand_elements = ElementBlocks<Element>(size) * stride;
      operands = arena.Allocate<Element>({operand_elements}).data();
      std::fill_n(operands, operand_elements, Element{});
    }
    projected = arena.Allocate<float>({floats}).data();
    q = arena.Allocate<Element>({elements}).data();
    for (std::size_t set = 0; set < k.size(); ++set) {
      k[set] = arena.Allocate<Element>({elements}).data();
      v[set] = arena.Allocate<Element>({elements}).data();
      std::fill_n(v[set], elements, Element{});
    }
  }

  int64_t count;
  int64_t rows;    // Whole blocks of elements, for values are the elements of a right operand.
  int64_t stride;  // Elements from a block to the next.
  float* tokens;
  Element* operands;  // The tokens as left operand.
  float* projected;   // Of image 1, packed.
  Element* q;
  // Layers in turn.
  std::array<Element*, kKeySets> k;
  std::array<Element*, kKeySets> v;
};

// Of one thread, for one band.
template <typename Element>
struct GraphNetwork<Element>::Scratch {
  float* scores;
  Element* attended;  // Also keys and values on their way to their places.
  Element* hidden;
  std::array<float*, 2> encoder;
};

template <typename Element>
template <typename Operand>
kernels::MatMul<Operand> GraphNetwork<Element>::Product(const Linear<Operand>& linear,
                                                        const Operand* rows, int64_t block_stride,
                                                        int64_t count) const {
  return {.a0 = rows,
          .a0_block_stride = block_stride,
          .a0_blocks = linear.blocks0,
          .b = linear.weights,
          .bias = linear.bias.data(),
          .columns = linear.columns,
          .rows = count};
}

// Token = descriptor + encoder(position and score).
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

// Queries, keys and values of a layer.
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
Projected GraphNetwork<Element>::Run(const Features& features0, const Features& features1,
                                     Workspace& workspace) const {
  Arena& arena = workspace.arena;
  ThreadPool& pool = workspace.pool;
  const std::array<const Features*, 2> features = {&features0, &features1};
  std::array<Image, 2> images = {
      Image(features0.size(), weights_.size, weights_.heads * weights_.head_size, arena),
      Image(features1.size(), weights_.size, weights_.heads * weights_.head_size, arena)};

  // Bands of about the same height that keep the register tiles full, and enough of them for all
  // threads.
  int64_t band_rows = kMostBandRows;
  const auto bands_of = [&](int64_t count) { return (count + band_rows - 1) / band_rows; };
  while (band_rows > kBlock &&
         bands_of(images[0].count) + bands_of(images[1].count) < 4 * pool.size()) {
    band_rows -= kBlock;
  }
  const int64_t bands0 = bands_of(images[0].count);
  const int64_t bands1 = bands_of(images[1].count);
  const auto band_of = [&](int64_t task) -> Band {
    const int image = task < bands0 ? 0 : 1;
    const int64_t index = task - image * bands0;
    const int64_t count = images[image].count;
    const int64_t parts = image == 0 ? bands0 : bands1;
    const int64_t begin = BlocksOf(count) * index / parts * kBlock;
    const int64_t end = BlocksOf(count) * (index + 1) / parts * kBlock;
    return {image, begin, std::min(end, count) - begin};
  };

  const int64_t most = std::max(images[0].count, images[1].count);
  const TensorView<float> scores =
      arena.Allocate<float>({pool.size(), kernels::AttentionScratchFloats(most)});
  const TensorView<Element> attended = arena.Allocate<Element>(
      {pool.size(), weights_.heads * weights_.head_size / kChannelsPer<Element> * band_rows});
  const TensorView<Element> hidden = arena.Allocate<Element>(
      {pool.size(), weights_.hidden_size / kChannelsPer<Element> * band_rows});
  const TensorView<float> encoder = arena.Allocate<float>(
      {pool.size(), 2 * std::max<int64_t>(weights_.widest, kBlock) * band_rows});
  // Step 0 encodes, step i + 1 is layer i, and the last one projects. First in a step is the image
  // that attends to keys and values which are all there while the last bands of the step before are
  // still at work: from one layer of cross-attention to the next the images take turns.
  const auto layers = static_cast<int64_t>(weights_.layers.size());
  const int64_t bands = bands0 + bands1;
  StepProgress progress(arena.Allocate<int32_t>({2 * (layers + 2)}).data(),
                        arena.Allocate<int32_t>({bands}).data(), {bands0, bands1}, layers + 2);
  const auto is_cross = [](int64_t layer) { return layer % 2 == 1; };
  pool.ParallelFor((layers + 2) * bands, [&](int64_t task, int worker) {
    const int64_t step = task / bands;
    const bool flipped = step / 2 % 2 == 1;  // Layers of cross-attention so far.
    const int64_t turn = task % bands;
    const int64_t index = !flipped ? turn : turn < bands1 ? bands0 + turn : turn - bands1;
    const Band band = band_of(index);
    Image& image = images[band.image];
    float* const encoder_of_worker = encoder.data() + worker * encoder.extent(1);
    Scratch scratch = {scores.data() + worker * scores.extent(1),
                       attended.data() + worker * attended.extent(1),
                       hidden.data() + worker * hidden.extent(1),
                       {encoder_of_worker, encoder_of_worker + encoder.extent(1) / 2}};
    if (step == 0) {
      Encode(*features[band.image], band, image, scratch);
    } else {
      progress.WaitForBand(step - 1, index);
    }
    if (step > 0 && step <= layers) {
      const int source = is_cross(step - 1) ? 1 - band.image : band.image;
      progress.WaitForImage(step - 1, source);
      RunLayer(weights_.layers[step - 1], band, image, images[source],
               static_cast<int>((step - 1) % kKeySets), scratch);
    }
    if (step < layers) {
      if (step >= 2) {  // Its keys and values are overwritten.
        progress.WaitForImage(step - 2, 0);
        progress.WaitForImage(step - 2, 1);
      }
      Project(weights_.layers[step], band, image, static_cast<int>(step % kKeySets), scratch);
    }
    if (step == layers + 1) {
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
    progress.Pass(step, band.image, index);
  });
  return {images[0].projected, images[0].stride, BlocksOf(weights_.size), images[1].projected};
}

template class GraphNetwork<float>;
template class GraphNetwork<kernels::Bf16Pair>;

}  // namespace gluevo::nn
