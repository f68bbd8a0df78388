#include <algorithm>

#include "aliked_network.h"

namespace gluevo::nn {

using kernels::kPlaneMargin;

namespace {

struct Planes {
  float* data = nullptr;
  int64_t row_stride = 0;
  int64_t plane_stride = 0;
};

// With a halo of zeros.
Planes NewPlanes(int64_t channels, const AlikedMaps& maps, Workspace& workspace) {
  Planes planes;
  planes.row_stride = maps.padded_width + 2 * kPlaneMargin;
  planes.plane_stride = (maps.padded_height + 2) * planes.row_stride;
  planes.data = workspace.arena.Allocate<float>({channels * planes.plane_stride}).data();
  for (int64_t channel = 0; channel < channels; ++channel) {
    float* row = planes.data + channel * planes.plane_stride;
    std::fill_n(row, planes.row_stride, 0.0F);
    for (int64_t y = 0; y < maps.padded_height; ++y) {
      row += planes.row_stride;
      std::fill_n(row, kPlaneMargin, 0.0F);
      std::fill_n(row + kPlaneMargin + maps.padded_width, kPlaneMargin, 0.0F);
    }
    std::fill_n(row + planes.row_stride, planes.row_stride, 0.0F);
  }
  return planes;
}

}  // namespace

TensorView<float> AlikedNetwork::Scores(const AlikedMaps& maps, Workspace& workspace) const {
  Planes planes = NewPlanes(layers_.score_channels, maps, workspace);
  const TensorView<float> scratch = workspace.arena.Allocate<float>(
      {workspace.pool.size(),
       kernels::ScoreScratchFloats(maps.scores[1].width, maps.scores[2].width,
                                   maps.scores[3].width)});
  workspace.pool.ParallelFor(maps.padded_height, [&](int64_t y, int worker) {
    kernels::ScoreRow row = {
        .row = maps.fine_scores.data() + y * maps.padded_width * maps.fine_scores.extent(2),
        .width = maps.padded_width,
        .channels = layers_.score_channels,
        .out = planes.data + (y + 1) * planes.row_stride + kPlaneMargin,
        .plane_stride = planes.plane_stride,
        .scratch = scratch.data() + worker * scratch.extent(1)};
    for (std::size_t i = 0; i < 3; ++i) {
      row.maps[i] = maps.scores[i + 1];
      row.tap_y[i] = maps.taps_y[i][y];
      row.taps_x[i] = maps.taps_x[i];
    }
    open_->score_row(row);
  });
  for (std::size_t i = 0; i < layers_.score_layers.size(); ++i) {
    const Tensor<float>& weights = layers_.score_layers[i];
    const Planes out = NewPlanes(weights.extent(0), maps, workspace);
    const bool last = i + 1 == layers_.score_layers.size();
    constexpr int64_t kRows = 8;  // Of which the padded height is a multiple.
    workspace.pool.ParallelFor(maps.padded_height / kRows, [&](int64_t band, int /*worker*/) {
      open_->planar_conv3x3(
          {.in = planes.data,
           .in_channels = weights.extent(1),
           .weights = weights.data(),
           .activation = last ? kernels::Activation::kSigmoid : kernels::Activation::kSelu,
           .out = out.data,
           .out_channels = weights.extent(0),
           .height = maps.padded_height,
           .width = maps.padded_width,
           .row_stride = planes.row_stride,
           .plane_stride = planes.plane_stride,
           .row_begin = band * kRows,
           .row_end = (band + 1) * kRows});
    });
    planes = out;
  }
  const TensorView<float> scores = workspace.arena.Allocate<float>({maps.height, maps.width});
  for (int64_t y = 0; y < maps.height; ++y) {
    std::copy_n(planes.data + (maps.top + y + 1) * planes.row_stride + kPlaneMargin + maps.left,
                maps.width, scores.data() + y * maps.width);
  }
  return scores;
}

}  // namespace gluevo::nn
