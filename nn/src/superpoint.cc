#include "gluevo/nn/superpoint.h"

#include <algorithm>
#include <cmath>

#include "kernels/kernels.h"

namespace gluevo::nn {
namespace {

using kernels::BlockedMap;
using kernels::BlocksOf;
using kernels::kBlock;

// Rows of output that a thread takes at a time.
constexpr int64_t kBandRows = 8;

constexpr const char* kTrunkNames[] = {"conv1a", "conv1b", "conv2a", "conv2b",
                                       "conv3a", "conv3b", "conv4a", "conv4b"};

bool PoolsAfter(std::size_t layer) { return layer == 1 || layer == 3 || layer == 5; }

BlockedMap AllocateMap(int64_t channels, int64_t height, int64_t width, Arena& arena) {
  const int64_t blocks = BlocksOf(channels);
  const BlockedMap map{arena.Allocate<float>({BlockedMap::Floats(blocks, height, width)}).data(),
                       blocks, height, width};
  kernels::ClearHalo(map);
  return map;
}

// Calls f(begin, end, worker) for bands of rows of [0, rows).
template <typename F>
void ForBands(ThreadPool& pool, int64_t rows, int64_t band_rows, const F& f) {
  pool.ParallelFor((rows + band_rows - 1) / band_rows, [&](int64_t band, int worker) {
    f(band * band_rows, std::min(rows, (band + 1) * band_rows), worker);
  });
}

// The image as floats 0 to 1 with a halo of zeros: [height + 2][width + 2].
float* GrayPlane(const GrayImage& image, Arena& arena, ThreadPool& pool) {
  const int64_t stride = image.width + 2;
  const TensorView<float> plane = arena.Allocate<float>({image.height + 2, stride});
  plane.Matrix().row(0).setZero();
  plane.Matrix().row(image.height + 1).setZero();
  ForBands(pool, image.height, 64, [&](int64_t begin, int64_t end, int /*worker*/) {
    for (int64_t y = begin; y < end; ++y) {
      float* const to = plane.data() + (y + 1) * stride;
      const uint8_t* const from = image.data + y * image.stride;
      to[0] = 0.0F;
      for (int64_t x = 0; x < image.width; ++x) {
        to[x + 1] = static_cast<float>(from[x]) / 255.0F;
      }
      to[image.width + 1] = 0.0F;
    }
  });
  return plane.data();
}

// Where along one axis the parabola through the logarithms of the score at `index` and of its two
// neighbours peaks, relative to it. `position` is the index on this axis, `step` the distance of
// neighbours.
float PeakOffset(TensorView<const float> scores, int64_t index, int64_t position, int64_t step) {
  const int64_t extent = step == 1 ? scores.extent(1) : scores.extent(0);
  if (position < 1 || position + 1 >= extent) {
    return 0.0F;
  }
  constexpr float kLeast = 1e-9F;
  const auto log_score = [&](int64_t i) { return std::log(std::max(scores[i], kLeast)); };
  const float before = log_score(index - step);
  const float after = log_score(index + step);
  const float curvature = before + after - 2.0F * log_score(index);
  return curvature < 0.0F ? std::clamp(0.5F * (before - after) / curvature, -0.5F, 0.5F) : 0.0F;
}

void NormalizeRow(float* row, int64_t size) {
  Eigen::Map<Eigen::VectorXf> vector(row, size);
  const float norm = vector.norm();
  if (norm > 0.0F) {
    vector /= norm;
  }
}

}  // namespace

void SuperPointOptions::Validate() const {
  if (!(keypoint_threshold >= 0.0F && keypoint_threshold < 1.0F)) {
    throw Error("keypoint threshold " + std::to_string(keypoint_threshold) +
                " is out of range: expected 0 or more and below 1");
  }
  if (nms_radius < 0 || nms_radius > 64) {
    throw Error("non-maximum suppression radius " + std::to_string(nms_radius) +
                " is out of range: expected 0 to 64 pixels");
  }
  if (border < 0) {
    throw Error("keypoint border " + std::to_string(border) + " is negative");
  }
  if (max_keypoints < 1) {
    throw Error("maximum number of keypoints " + std::to_string(max_keypoints) +
                " is out of range: expected at least 1");
  }
}

SuperPoint::Convolution SuperPoint::Load(const Weights& weights, const char* name,
                                         int64_t kernel_size, int64_t in_channels) {
  const std::string weight_name = std::string(name) + ".weight";
  const Tensor<float>& weight = weights.Get(weight_name);
  Convolution layer;
  layer.in_channels = in_channels;
  layer.out_channels = weight.shape().rank() == 4 ? weight.extent(0) : 0;
  CheckShape(weight.shape(), {layer.out_channels, in_channels, kernel_size, kernel_size},
             weights.source + ": " + weight_name);
  const Tensor<float>& bias = weights.Get(std::string(name) + ".bias", Shape{layer.out_channels});
  layer.bias = Tensor<float>({BlocksOf(layer.out_channels) * kBlock});
  std::copy_n(bias.data(), bias.size(), layer.bias.data());
  if (kernel_size == 3) {
    layer.weights = Tensor<float>({kernels::PackedConv3x3Floats(layer.out_channels, in_channels)});
    kernels::PackConv3x3(weight.data(), layer.out_channels, in_channels, layer.weights.data());
  } else {
    layer.weights = Tensor<float>({kernels::PackedMatrixFloats(layer.out_channels, in_channels)});
    kernels::PackMatrix(weight.data(), in_channels, layer.out_channels, in_channels,
                        layer.weights.data());
  }
  return layer;
}

SuperPoint::SuperPoint(const Weights& weights, Isa isa) : kernels_(&kernels::KernelsFor(isa)) {
  if (!weights.Has("conv1a.weight")) {
    throw Error(weights.source + ": not the weights of a SuperPoint: no tensor conv1a.weight" +
                (weights.Has("kenc.encoder.0.weight") ? " (these are a SuperGlue's)" : ""));
  }
  int64_t channels = 1;
  for (const char* const name : kTrunkNames) {
    trunk_.push_back(Load(weights, name, 3, channels));
    channels = trunk_.back().out_channels;
  }
  detector_a_ = Load(weights, "convPa", 3, channels);
  detector_b_ = Load(weights, "convPb", 1, detector_a_.out_channels);
  descriptor_a_ = Load(weights, "convDa", 3, channels);
  descriptor_b_ = Load(weights, "convDb", 1, descriptor_a_.out_channels);
  descriptor_size_ = static_cast<int>(descriptor_b_.out_channels);
  if (detector_b_.out_channels != 65) {
    throw Error(weights.source + ": convPb has " + std::to_string(detector_b_.out_channels) +
                " outputs, expected 65 (8 x 8 pixels and none)");
  }
}

SuperPoint::DenseMaps SuperPoint::Dense(const GrayImage& image, Workspace& workspace) const {
  if (image.width < 8 || image.height < 8) {
    throw Error("an image of " + std::to_string(image.width) + " x " +
                std::to_string(image.height) + " pixels: SuperPoint needs at least 8 x 8");
  }
  Arena& arena = workspace.arena;
  ThreadPool& pool = workspace.pool;
  arena.Reset();

  const auto convolve = [&](const Convolution& layer, const BlockedMap& in, bool relu, bool pools) {
    const BlockedMap out = AllocateMap(layer.out_channels, pools ? in.height / 2 : in.height,
                                       pools ? in.width / 2 : in.width, arena);
    ForBands(pool, out.height, kBandRows, [&](int64_t begin, int64_t end, int /*worker*/) {
      kernels_->conv3x3({.in = in,
                         .weights = layer.weights.data(),
                         .bias = layer.bias.data(),
                         .relu = relu,
                         .pool = pools,
                         .out = out,
                         .row_begin = begin,
                         .row_end = end});
    });
    return out;
  };

  // The first layer's output is the largest of all and costs little: each thread computes the rows
  // that its band of the second layer needs, and drops them.
  const Convolution& first = trunk_[0];
  const Convolution& second = trunk_[1];
  const float* const gray = GrayPlane(image, arena, pool);
  const int64_t width = image.width;
  const int64_t height = image.height;
  const int64_t first_blocks = BlocksOf(first.out_channels);
  const int64_t band_floats = BlockedMap::Floats(first_blocks, 2 * kBandRows, width);
  const TensorView<float> bands = arena.Allocate<float>({pool.size(), band_floats});
  BlockedMap map = AllocateMap(second.out_channels, height / 2, width / 2, arena);
  ForBands(pool, map.height, kBandRows, [&](int64_t begin, int64_t end, int worker) {
    const BlockedMap band{bands.data() + worker * band_floats, first_blocks, 2 * (end - begin),
                          width};
    kernels::ClearHalo(band);
    // Row y of the band is row 2 begin + y of the image; the band's halo rows are the neighbours.
    kernels_->conv3x3({.in = {.data = const_cast<float*>(gray) + 2 * begin * (width + 2),
                              .blocks = 1,
                              .height = height,
                              .width = width},
                       .gray = true,
                       .weights = first.weights.data(),
                       .bias = first.bias.data(),
                       .relu = true,
                       .out = band,
                       .row_begin = begin == 0 ? 0 : -1,
                       .row_end = std::min(band.height + 1, height - 2 * begin)});
    BlockedMap out = map;
    out.data += begin * map.row_stride();
    kernels_->conv3x3({.in = band,
                       .weights = second.weights.data(),
                       .bias = second.bias.data(),
                       .relu = true,
                       .pool = true,
                       .out = out,
                       .row_begin = 0,
                       .row_end = end - begin});
  });
  for (std::size_t layer = 2; layer < trunk_.size(); ++layer) {
    map = convolve(trunk_[layer], map, true, PoolsAfter(layer));
  }

  const int64_t cell_rows = map.height;
  const int64_t cell_columns = map.width;
  const auto project = [&](const Convolution& layer, const BlockedMap& in, int64_t stride) {
    const TensorView<float> out = arena.Allocate<float>({cell_rows, cell_columns, stride});
    pool.ParallelFor(cell_rows, [&](int64_t y, int /*worker*/) {
      kernels_->matmul({.a0 = in.pixel(0, y, 0),
                        .a0_stride = kBlock,
                        .a0_block_stride = in.block_stride(),
                        .k0 = layer.in_channels,
                        .b = layer.weights.data(),
                        .bias = layer.bias.data(),
                        .c = out.data() + y * cell_columns * stride,
                        .c_stride = stride,
                        .columns = layer.out_channels,
                        .row_begin = 0,
                        .row_end = cell_columns});
    });
    return out;
  };

  const int64_t logit_stride = BlocksOf(65) * kBlock;
  const TensorView<float> logits =
      project(detector_b_, convolve(detector_a_, map, true, false), logit_stride);
  DenseMaps maps;
  maps.scores = arena.Allocate<float>({cell_rows * 8, cell_columns * 8});
  pool.ParallelFor(cell_rows, [&](int64_t y, int /*worker*/) {
    kernels_->detector_softmax({.logits = logits.data(),
                                .stride = logit_stride,
                                .cell_columns = cell_columns,
                                .scores = maps.scores.data(),
                                .cell_row_begin = y,
                                .cell_row_end = y + 1});
  });

  maps.descriptors =
      project(descriptor_b_, convolve(descriptor_a_, map, true, false), descriptor_size_);
  pool.ParallelFor(cell_rows, [&](int64_t y, int /*worker*/) {
    for (int64_t x = 0; x < cell_columns; ++x) {
      NormalizeRow(maps.descriptors.data() + (y * cell_columns + x) * descriptor_size_,
                   descriptor_size_);
    }
  });
  return maps;
}

void SuperPoint::Extract(const GrayImage& image, const SuperPointOptions& options,
                         Workspace& workspace, Features& features) const {
  options.Validate();
  const DenseMaps maps = Dense(image, workspace);
  std::vector<int64_t>& selected = workspace.candidates;
  SelectKeypoints(maps.scores, options, workspace, selected);

  const int64_t width = maps.scores.extent(1);
  features.width = image.width;
  features.height = image.height;
  features.keypoints.resize(static_cast<Eigen::Index>(selected.size()), 2);
  features.scores.resize(static_cast<Eigen::Index>(selected.size()));
  for (std::size_t i = 0; i < selected.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    features.keypoints(row, 0) = static_cast<float>(selected[i] % width);
    features.keypoints(row, 1) = static_cast<float>(selected[i] / width);
    features.scores[row] = maps.scores[selected[i]];
    if (options.subpixel) {
      features.keypoints(row, 0) += PeakOffset(maps.scores, selected[i], selected[i] % width, 1);
      features.keypoints(row, 1) +=
          PeakOffset(maps.scores, selected[i], selected[i] / width, width);
    }
  }
  SampleDescriptors(maps.descriptors, features.keypoints, features.descriptors);
}

void SuperPoint::Describe(const GrayImage& image, Workspace& workspace, Features& features) const {
  const DenseMaps maps = Dense(image, workspace);
  const int64_t width = maps.scores.extent(1);
  const int64_t height = maps.scores.extent(0);
  features.width = image.width;
  features.height = image.height;
  features.scores.resize(features.keypoints.rows());
  for (Eigen::Index i = 0; i < features.keypoints.rows(); ++i) {
    const int64_t x = std::clamp<int64_t>(std::lround(features.keypoints(i, 0)), 0, width - 1);
    const int64_t y = std::clamp<int64_t>(std::lround(features.keypoints(i, 1)), 0, height - 1);
    features.scores[i] = maps.scores[y * width + x];
  }
  SampleDescriptors(maps.descriptors, features.keypoints, features.descriptors);
}

void SampleDescriptors(TensorView<const float> map,
                       const Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor>& keypoints,
                       Features::RowMajor& descriptors) {
  const int64_t rows = map.extent(0);
  const int64_t columns = map.extent(1);
  const int64_t size = map.extent(2);
  using ConstRow = Eigen::Map<const Eigen::RowVectorXf>;
  const auto cell = [&](int64_t y, int64_t x) {
    return ConstRow(map.data() + (y * columns + x) * size, size);
  };
  // Position on a side of `cells` cells: first cell, its neighbour, and the neighbour's weight.
  struct Tap {
    int64_t low, high;
    float weight;
  };
  const auto tap = [](float pixel, int64_t cells) {
    const auto side = static_cast<float>(cells);
    const float at = (pixel - 3.5F) / (8.0F * side - 4.5F) * (side - 1.0F);
    const float inside = std::clamp(at, 0.0F, side - 1.0F);
    const auto low = static_cast<int64_t>(inside);
    return Tap{low, std::min(low + 1, cells - 1), inside - static_cast<float>(low)};
  };

  descriptors.resize(keypoints.rows(), size);
  for (Eigen::Index i = 0; i < keypoints.rows(); ++i) {
    const Tap x = tap(keypoints(i, 0), columns);
    const Tap y = tap(keypoints(i, 1), rows);
    descriptors.row(i) =
        (1.0F - y.weight) *
            ((1.0F - x.weight) * cell(y.low, x.low) + x.weight * cell(y.low, x.high)) +
        y.weight * ((1.0F - x.weight) * cell(y.high, x.low) + x.weight * cell(y.high, x.high));
    NormalizeRow(&descriptors(i, 0), size);
  }
}

}  // namespace gluevo::nn
