#include "gluevo/nn/superpoint.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "descriptor_sampling.h"
#include "gluevo/nn/option_error.h"
#include "kernels/kernels.h"
#include "kernels/winograd.h"
#include "superpoint_layers.h"

namespace gluevo::nn {
namespace {

using kernels::BlockedMap;
using kernels::BlocksOf;
using kernels::kBlock;

constexpr const char* kTrunkNames[] = {"conv1a", "conv1b", "conv2a", "conv2b",
                                       "conv3a", "conv3b", "conv4a", "conv4b"};

bool PoolsAfter(std::size_t layer) { return layer == 1 || layer == 3 || layer == 5; }

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

}  // namespace

void SuperPointOptions::Validate() const {
  if (!(keypoint_threshold >= 0.0F && keypoint_threshold < 1.0F)) {
    throw OptionError("keypoint threshold " + std::to_string(keypoint_threshold) +
                      " is out of range: expected 0 or more and below 1");
  }
  if (nms_radius < 0 || nms_radius > 64) {
    throw OptionError("non-maximum suppression radius " + std::to_string(nms_radius) +
                      " is out of range: expected 0 to 64 pixels");
  }
  if (border < 0) {
    throw OptionError("keypoint border " + std::to_string(border) + " is negative");
  }
  if (max_keypoints < 1) {
    throw OptionError("maximum number of keypoints " + std::to_string(max_keypoints) +
                      " is out of range: expected at least 1");
  }
}

SuperPoint::SuperPoint(SuperPoint&&) noexcept = default;
SuperPoint& SuperPoint::operator=(SuperPoint&&) noexcept = default;
SuperPoint::~SuperPoint() = default;

SuperPoint::SuperPoint(const Weights& weights, Isa isa) : kernels_(&kernels::KernelsFor(isa)) {
  if (!weights.Has("conv1a.weight")) {
    throw Error(weights.source + ": not the weights of a SuperPoint: no tensor conv1a.weight" +
                (weights.Has("kenc.encoder.0.weight") ? " (these are a SuperGlue's)"
                                                      : " (gluevo-weights converts other forms)"));
  }
  std::vector<Convolution> trunk;
  int64_t channels = 1;
  for (const char* const name : kTrunkNames) {
    trunk.emplace_back(weights, name, 3, channels, *kernels_);
    trunk.back().pool = PoolsAfter(trunk.size() - 1);
    channels = trunk.back().out_channels;
  }
  const auto read_head = [&](const std::string& name) -> Head {
    Convolution hidden(weights, name + "a", 3, channels, *kernels_);
    Convolution output(weights, name + "b", 1, hidden.out_channels, *kernels_);
    return {std::move(hidden), std::move(output)};
  };
  layers_ = std::make_unique<const Layers>(
      Layers{std::move(trunk), read_head("convP"), read_head("convD")});
  descriptor_size_ = static_cast<int>(layers_->descriptor.output.out_channels);
  const int64_t detector_channels = layers_->detector.output.out_channels;
  if (detector_channels != 65) {
    throw Error(weights.source + ": convPb has " + std::to_string(detector_channels) +
                " outputs, expected 65 (8 x 8 pixels and none)");
  }
}

double SuperPoint::Flops(int width, int height) const {
  const auto at = [&](const Convolution& layer, int taps, int64_t pixels) {
    return 2.0 * taps * static_cast<double>(layer.in_channels * layer.out_channels * pixels);
  };
  int64_t columns = width;
  int64_t rows = height;
  double flops = 0.0;
  for (const Convolution& layer : layers_->trunk) {
    flops += at(layer, 9, rows * columns);
    columns = layer.pool ? columns / 2 : columns;
    rows = layer.pool ? rows / 2 : rows;
  }
  for (const Head* const head : {&layers_->detector, &layers_->descriptor}) {
    flops += at(head->hidden, 9, rows * columns) + at(head->output, 1, rows * columns);
  }
  return flops;
}

void SuperPoint::Project(const Convolution& layer, const float* pixels, int64_t block_stride,
                         int64_t count, float* out, int64_t out_stride) const {
  kernels_->matmul({.a0 = pixels,
                    .a0_block_stride = block_stride,
                    .a0_blocks = BlocksOf(layer.in_channels),
                    .b = layer.weights.data(),
                    .bias = layer.bias.data(),
                    .c = out,
                    .c_stride = out_stride,
                    .c_block_stride = kBlock,
                    .columns = layer.out_channels,
                    .rows = count});
}

TensorView<float> SuperPoint::Scores(const BlockedMap& trunk, Workspace& workspace,
                                     const Buffers& buffers) const {
  const Head& head = layers_->detector;
  const BlockedMap hidden =
      buffers.Output(trunk, head.hidden.out_channels, trunk.height, trunk.width);
  Convolve(head.hidden, trunk, hidden, workspace, buffers);
  const int64_t stride = BlocksOf(65) * kBlock;
  const TensorView<float> logits =
      workspace.arena.Allocate<float>({workspace.pool.size(), trunk.width, stride});
  const TensorView<float> scores =
      workspace.arena.Allocate<float>({trunk.height * 8, trunk.width * 8});
  workspace.pool.ParallelFor(trunk.height, [&](int64_t y, int worker) {
    float* const row = logits.data() + worker * trunk.width * stride;
    Project(head.output, hidden.pixel(0, y, 0), hidden.block_stride(), trunk.width, row, stride);
    kernels_->detector_softmax({.logits = row,
                                .stride = stride,
                                .cell_columns = trunk.width,
                                .scores = scores.data() + y * 8 * trunk.width * 8,
                                .cell_row_begin = 0,
                                .cell_row_end = 1});
  });
  return scores;
}

void SuperPoint::DescribeAt(const BlockedMap& trunk, Workspace& workspace, const Buffers& buffers,
                            Features& features) const {
  const Head& head = layers_->descriptor;
  Arena& arena = workspace.arena;
  const int64_t cells = trunk.height * trunk.width;
  // Only the cells that a keypoint samples are projected, their rows put together, and only the
  // tiles of cells around them convolved: with 500 keypoints half of all tiles, with 200 a third
  // (KITTI, EuRoC, graf).
  const TensorView<int32_t> row_of_cell = arena.Allocate<int32_t>({cells});
  const TensorView<int32_t> cell_of_row =
      arena.Allocate<int32_t>({std::min<int64_t>(cells, 4 * features.size())});
  std::fill_n(row_of_cell.data(), cells, -1);
  int32_t rows = 0;
  for (Eigen::Index i = 0; i < features.keypoints.rows(); ++i) {
    for (const int64_t cell :
         TapsAt(features.keypoints(i, 0), features.keypoints(i, 1), trunk.height, trunk.width)
             .cells) {
      if (row_of_cell[cell] < 0) {
        cell_of_row[rows] = static_cast<int32_t>(cell);
        row_of_cell[cell] = rows++;
      }
    }
  }

  const BlockedMap hidden =
      buffers.Output(trunk, head.hidden.out_channels, trunk.height, trunk.width);
  if (head.hidden.kernel == kernels_->winograd3x3) {
    const int64_t tile_columns = (trunk.width + 3) / 4;
    const int64_t all_tiles = (trunk.height + 3) / 4 * tile_columns;
    const TensorView<int32_t> tiles = arena.Allocate<int32_t>({all_tiles});
    std::fill_n(tiles.data(), all_tiles, 0);
    for (int32_t row = 0; row < rows; ++row) {
      const int64_t cell = cell_of_row[row];
      tiles[cell / trunk.width / 4 * tile_columns + cell % trunk.width / 4] = 1;
    }
    int64_t tile_count = 0;
    for (int64_t tile = 0; tile < all_tiles; ++tile) {
      if (tiles[tile] != 0) {
        tiles[tile_count++] = static_cast<int32_t>(tile);
      }
    }
    const int64_t parts = (tile_count + kernels::kWinogradTiles - 1) / kernels::kWinogradTiles;
    workspace.pool.ParallelFor(parts, [&](int64_t part, int worker) {
      const int64_t begin = tile_count * part / parts;
      kernels::Conv3x3 task = head.hidden.Of(trunk, hidden, buffers, worker);
      task.tiles = tiles.data() + begin;
      task.tile_count = tile_count * (part + 1) / parts - begin;
      head.hidden.kernel(task);
    });
  } else {
    Convolve(head.hidden, trunk, hidden, workspace, buffers);
  }

  constexpr int64_t kRows = 56;
  const TensorView<float> gathered =
      arena.Allocate<float>({workspace.pool.size(), hidden.blocks, kRows, kBlock});
  const TensorView<float> projected = arena.Allocate<float>({rows, descriptor_size_});
  workspace.pool.ParallelFor((rows + kRows - 1) / kRows, [&](int64_t band, int worker) {
    const int64_t begin = band * kRows;
    const int64_t end = std::min<int64_t>(rows, begin + kRows);
    float* const operands = gathered.data() + worker * hidden.blocks * kRows * kBlock;
    for (int64_t block = 0; block < hidden.blocks; ++block) {
      for (int64_t row = begin; row < end; ++row) {
        const int64_t cell = cell_of_row[row];
        std::copy_n(hidden.pixel(block, cell / trunk.width, cell % trunk.width), kBlock,
                    operands + (block * kRows + row - begin) * kBlock);
      }
    }
    Project(head.output, operands, kRows * kBlock, end - begin,
            projected.data() + begin * descriptor_size_, descriptor_size_);
    for (int64_t row = begin; row < end; ++row) {
      NormalizeRow(projected.data() + row * descriptor_size_, descriptor_size_);
    }
  });
  SampleCells(
      features.keypoints, trunk.height, trunk.width, descriptor_size_,
      [&](int64_t cell) { return projected.data() + row_of_cell[cell] * descriptor_size_; },
      features.descriptors);
}

SuperPoint::DenseMaps SuperPoint::Dense(const GrayImage& image, Workspace& workspace) const {
  Buffers buffers;
  const BlockedMap trunk = Trunk(image, Heads::kBoth, workspace, buffers);
  const Head& head = layers_->descriptor;
  DenseMaps maps;
  maps.scores = Scores(trunk, workspace, buffers);
  maps.descriptors = workspace.arena.Allocate<float>({trunk.height, trunk.width, descriptor_size_});
  const BlockedMap hidden =
      buffers.Output(trunk, head.hidden.out_channels, trunk.height, trunk.width);
  Convolve(head.hidden, trunk, hidden, workspace, buffers);
  workspace.pool.ParallelFor(trunk.height, [&](int64_t y, int /*worker*/) {
    float* const row = maps.descriptors.data() + y * trunk.width * descriptor_size_;
    Project(head.output, hidden.pixel(0, y, 0), hidden.block_stride(), trunk.width, row,
            descriptor_size_);
    for (int64_t x = 0; x < trunk.width; ++x) {
      NormalizeRow(row + x * descriptor_size_, descriptor_size_);
    }
  });
  return maps;
}

void SuperPoint::Extract(const GrayImage& image, const SuperPointOptions& options,
                         Workspace& workspace, Features& features) const {
  options.Validate();
  Buffers buffers;
  const BlockedMap trunk = Trunk(image, Heads::kBoth, workspace, buffers);
  const TensorView<float> scores = Scores(trunk, workspace, buffers);
  std::vector<int64_t>& selected = workspace.candidates;
  SelectKeypoints(scores, options, workspace, selected);

  const int64_t width = scores.extent(1);
  features.width = image.width;
  features.height = image.height;
  features.keypoints.resize(static_cast<Eigen::Index>(selected.size()), 2);
  features.scores.resize(static_cast<Eigen::Index>(selected.size()));
  for (std::size_t i = 0; i < selected.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const int64_t y = selected[i] / width;
    features.keypoints(row, 0) = static_cast<float>(selected[i] % width);
    features.keypoints(row, 1) = static_cast<float>(y);
    features.scores[row] = scores[selected[i]];
    if (options.subpixel) {
      features.keypoints(row, 0) += PeakOffset(scores, selected[i], selected[i] % width, 1);
      features.keypoints(row, 1) += PeakOffset(scores, selected[i], y, width);
    }
  }
  DescribeAt(trunk, workspace, buffers, features);
  workspace.arena.Join();
}

void SuperPoint::Describe(const GrayImage& image, Workspace& workspace, Features& features) const {
  Buffers buffers;
  const BlockedMap trunk = Trunk(image, Heads::kDescriptor, workspace, buffers);
  features.width = image.width;
  features.height = image.height;
  features.scores.resize(0);
  DescribeAt(trunk, workspace, buffers, features);
  workspace.arena.Join();
}

void SampleDescriptors(TensorView<const float> map, const Features::Points& keypoints,
                       Features::RowMajor& descriptors) {
  const int64_t size = map.extent(2);
  SampleCells(
      keypoints, map.extent(0), map.extent(1), size,
      [&](int64_t cell) { return map.data() + cell * size; }, descriptors);
}

}  // namespace gluevo::nn
