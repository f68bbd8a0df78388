// The sparse deformable descriptor head (Zhao et al. 2023, section III-D).

#include <algorithm>
#include <array>
#include <cmath>

#include "aliked_network.h"
#include "descriptor_sampling.h"

namespace gluevo::nn {

using kernels::BlocksOf;
using kernels::kBlock;

namespace {

// Of a band.
constexpr int64_t kBandKeypoints = 28;
constexpr int64_t kPatchTaps = 9;
constexpr int64_t kAhead = 12;  // Pixels of a full-size map that are fetched together.

// Bilinear weights of the four pixels around a position, those outside of the image being zero.
struct Corners {
  std::array<int32_t, 4> x;
  std::array<int32_t, 4> y;
  std::array<float, 4> weights;
};

Corners CornersOf(float x, float y, int64_t width, int64_t height) {
  Corners corners;
  const float left = std::floor(x);
  const float top = std::floor(y);
  for (std::size_t i = 0; i < 4; ++i) {
    const float u = left + static_cast<float>(i % 2);
    const float v = top + static_cast<float>(i / 2);
    const bool inside =
        u >= 0.0F && u < static_cast<float>(width) && v >= 0.0F && v < static_cast<float>(height);
    corners.weights[i] = inside ? (1.0F - std::abs(x - u)) * (1.0F - std::abs(y - v)) : 0.0F;
    corners.x[i] = inside ? static_cast<int32_t>(u) : 0;
    corners.y[i] = inside ? static_cast<int32_t>(v) : 0;
  }
  return corners;
}

}  // namespace

/// Keypoints that are described together.
struct AlikedNetwork::PointBand {
  const float* points;  ///< x and y of each.
  int64_t count;

  float x(int64_t i) const { return points[2 * i]; }
  float y(int64_t i) const { return points[2 * i + 1]; }
};

/// Of one thread, for one band.
struct AlikedNetwork::DescriptorScratch {
  float* patches;   ///< [9][blocks][keypoint][kBlock]: features of the pixels of a patch.
  float* offsets;   ///< Of the samples, and what they are made from: two of [blocks][keypoint].
  float* corners;   ///< [blocks][corner * keypoints + keypoint]
  float* sampled;   ///< [blocks][keypoint]
  float* samples;   ///< [sample][blocks][keypoint]
  float* gathered;  ///< Block 1's channels at four pixels of each keypoint.
  int32_t* pixels;  ///< Two of [4][keypoint].
};

void AlikedNetwork::FeaturesAt(const AlikedMaps& maps, kernels::FeatureRows rows,
                               float* scratch) const {
  const kernels::BlockedMap& block1 = maps.blocks[0];
  const int64_t stride = rows.count * kBlock;
  for (int64_t block = 0; block < block1.blocks; ++block) {
    const auto pixel = [&](int64_t i) {
      return block1.pixel(block, rows.pixels_y[i], rows.pixels_x[i]);
    };
    for (int64_t i = 0; i < rows.count; ++i) {
      // No cache holds the map.
      __builtin_prefetch(pixel(std::min(i + kAhead, rows.count - 1)));
      std::copy_n(pixel(i), kBlock, scratch + block * stride + i * kBlock);
    }
  }
  kernels::MatMul<float> product = Product(layers_.projections[0], scratch, stride, rows.count);
  product.c = rows.rows;
  product.c_block_stride = rows.block_stride;
  kernels_->matmul(product);
  rows.group_blocks = layers_.size / 4 / kBlock;
  for (std::size_t i = 0; i < 3; ++i) {
    rows.maps[i] = maps.features[i + 1];
    rows.taps_y[i] = maps.taps_y[i];
    rows.taps_x[i] = maps.taps_x[i];
  }
  open_->feature_rows(rows);
}

const float* AlikedNetwork::PredictOffsets(const AlikedMaps& maps, const PointBand& band,
                                           const DescriptorScratch& scratch) const {
  const int64_t blocks = layers_.size / kBlock;
  const int64_t stride = band.count * kBlock;
  int32_t* const xs = scratch.pixels;
  int32_t* const ys = scratch.pixels + 4 * kBandKeypoints;
  // Published: the last column and row never enter a patch.
  const auto first_of = [](float at, int64_t side) {
    return std::min(std::max<int64_t>(static_cast<int64_t>(at) - 1, 0),
                    std::max<int64_t>(side - 4, 0));
  };
  for (int64_t tap = 0; tap < kPatchTaps; ++tap) {
    for (int64_t i = 0; i < band.count; ++i) {
      xs[i] = static_cast<int32_t>(first_of(band.x(i), maps.width) + tap % 3 + maps.left);
      ys[i] = static_cast<int32_t>(first_of(band.y(i), maps.height) + tap / 3 + maps.top);
    }
    FeaturesAt(maps,
               {.rows = scratch.patches + tap * blocks * stride,
                .block_stride = stride,
                .pixels_y = ys,
                .pixels_x = xs,
                .count = band.count},
               scratch.gathered);
  }
  const int64_t offset_blocks = BlocksOf(2 * layers_.samples);
  float* const hidden = scratch.offsets;
  float* const offsets = scratch.offsets + offset_blocks * kBandKeypoints * kBlock;
  kernels::MatMul<float> product =
      Product(layers_.offsets_hidden, scratch.patches, stride, band.count);
  product.c = hidden;
  product.c_block_stride = stride;
  kernels_->matmul(product);
  open_->selu({.values = hidden, .count = offset_blocks * stride});
  product = Product(layers_.offsets_out, hidden, stride, band.count);
  product.c = offsets;
  product.c_block_stride = stride;
  kernels_->matmul(product);
  return offsets;
}

void AlikedNetwork::SampleFeatures(const AlikedMaps& maps, const PointBand& band, int64_t sample,
                                   const float* offsets, const DescriptorScratch& scratch) const {
  const int64_t blocks = layers_.size / kBlock;
  const int64_t count = band.count;
  const int64_t stride = count * kBlock;
  int32_t* const xs = scratch.pixels;
  int32_t* const ys = scratch.pixels + 4 * kBandKeypoints;
  const float limit = static_cast<float>(std::max(maps.width, maps.height)) / 4.0F;
  const auto offset = [&](int64_t channel, int64_t i) {
    return std::clamp(offsets[channel / kBlock * stride + i * kBlock + channel % kBlock], -limit,
                      limit);
  };
  std::array<std::array<float, 4>, kBandKeypoints> weights;
  for (int64_t i = 0; i < count; ++i) {
    const Corners at =
        CornersOf(band.x(i) + offset(sample, i), band.y(i) + offset(layers_.samples + sample, i),
                  maps.width, maps.height);
    weights[static_cast<std::size_t>(i)] = at.weights;
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const int64_t row = static_cast<int64_t>(corner) * count + i;
      xs[row] = at.x[corner] + static_cast<int32_t>(maps.left);
      ys[row] = at.y[corner] + static_cast<int32_t>(maps.top);
    }
  }
  FeaturesAt(maps,
             {.rows = scratch.corners,
              .block_stride = 4 * stride,
              .pixels_y = ys,
              .pixels_x = xs,
              .count = 4 * count},
             scratch.gathered);
  for (int64_t block = 0; block < blocks; ++block) {
    for (int64_t i = 0; i < count; ++i) {
      const float* const from = scratch.corners + block * 4 * stride + i * kBlock;
      const std::array<float, 4>& w = weights[static_cast<std::size_t>(i)];
      float* const to = scratch.sampled + block * stride + i * kBlock;
      for (int64_t c = 0; c < kBlock; ++c) {
        to[c] = (w[0] * from[c] + w[1] * from[stride + c]) +
                (w[2] * from[2 * stride + c] + w[3] * from[3 * stride + c]);
      }
    }
  }
}

void AlikedNetwork::DescribeBand(const AlikedMaps& maps, const PointBand& band,
                                 const DescriptorScratch& scratch, float* descriptors) const {
  const int64_t blocks = layers_.size / kBlock;
  const int64_t stride = band.count * kBlock;
  const float* const offsets = PredictOffsets(maps, band, scratch);
  kernels::MatMul<float> product;
  for (int64_t sample = 0; sample < layers_.samples; ++sample) {
    SampleFeatures(maps, band, sample, offsets, scratch);
    float* const activated = scratch.samples + sample * blocks * stride;
    product = Product(layers_.sample_features, scratch.sampled, stride, band.count);
    product.c = activated;
    product.c_block_stride = stride;
    kernels_->matmul(product);
    open_->selu({.values = activated, .count = blocks * stride});
  }
  product = Product(layers_.aggregation, scratch.samples, stride, band.count);
  product.c = descriptors;
  product.c_stride = layers_.size;
  product.c_block_stride = kBlock;
  kernels_->matmul(product);
  for (int64_t i = 0; i < band.count; ++i) {
    NormalizeRow(descriptors + i * layers_.size, layers_.size);
  }
}

void AlikedNetwork::Describe(const AlikedMaps& maps, Workspace& workspace,
                             Features& features) const {
  const int64_t keypoints = features.size();
  const int64_t bands = (keypoints + kBandKeypoints - 1) / kBandKeypoints;
  features.descriptors.resize(keypoints, layers_.size);
  const int64_t row = layers_.size * kBandKeypoints;
  Arena& arena = workspace.arena;
  const auto of_threads = [&](int64_t floats) {
    return arena.Allocate<float>({workspace.pool.size(), floats});
  };
  const int64_t offset_row = BlocksOf(2 * layers_.samples) * kBlock * kBandKeypoints;
  const TensorView<float> patches = of_threads(kPatchTaps * row);
  const TensorView<float> offsets = of_threads(2 * offset_row);
  const TensorView<float> corners = of_threads(4 * row);
  const TensorView<float> sampled = of_threads(row);
  const TensorView<float> samples = of_threads(layers_.samples * row);
  const TensorView<float> gathered =
      of_threads(4 * kBandKeypoints * BlocksOf(layers_.widths[0]) * kBlock);
  const TensorView<int32_t> pixels =
      arena.Allocate<int32_t>({workspace.pool.size(), 8 * kBandKeypoints});
  const auto of_worker = [](const auto& view, int worker) {
    return view.data() + worker * view.extent(1);
  };
  workspace.pool.ParallelFor(bands, [&](int64_t band, int worker) {
    const int64_t begin = keypoints * band / bands;
    const int64_t end = keypoints * (band + 1) / bands;
    DescribeBand(
        maps, {features.keypoints.data() + 2 * begin, end - begin},
        {of_worker(patches, worker), of_worker(offsets, worker), of_worker(corners, worker),
         of_worker(sampled, worker), of_worker(samples, worker), of_worker(gathered, worker),
         of_worker(pixels, worker)},
        features.descriptors.data() + begin * layers_.size);
  });
}

}  // namespace gluevo::nn
