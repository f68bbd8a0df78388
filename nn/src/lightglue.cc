#include "gluevo/nn/lightglue.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "lightglue_network.h"

namespace gluevo::nn {
namespace {

using kernels::BlocksOf;
using kernels::kBlock;

void CheckShare(float value, const char* name) {
  if (!(value >= 0.0F && value < 1.0F)) {
    throw Error(std::string(name) + " " + std::to_string(value) +
                " is out of range: expected 0 or more and below 1");
  }
}

void CheckFeatures(const Features& features, int64_t size) {
  if (features.size() == 0 || features.width < 1 || features.height < 1) {
    throw Error("an image without keypoints or without a size cannot be matched");
  }
  if (features.descriptors.cols() != size) {
    throw Error("descriptors of " + std::to_string(features.descriptors.cols()) +
                " values cannot be matched by a LightGlue of " + std::to_string(size) +
                ": the two networks do not belong together");
  }
  if (features.descriptors.rows() != features.size()) {
    throw Error(std::to_string(features.size()) + " keypoints with " +
                std::to_string(features.descriptors.rows()) +
                " descriptors cannot be matched: LightGlue needs one for each");
  }
}

float LogSigmoid(float x) { return std::min(x, 0.0F) - std::log1p(std::exp(-std::abs(x))); }

// Multiply-adds of a layer for one keypoint alone, as published.
double LayerSize(const LightGlueWeights& weights) {
  const auto size = static_cast<double>(weights.size);
  // Wqkv, out_proj, to_qk, to_v, to_out, and two MLPs.
  return size * size * (3 + 1 + 1 + 1 + 1) + 2.0 * (4.0 * size * size + 2.0 * size * size);
}

// The assignment of what is left, all but its last row and column: A_ij = 2 S_ij - lse_j(S_i.) -
// lse_i(S_.j) + log sigmoid(z_i) + log sigmoid(z_j). [n0 x whole blocks of n1]
TensorView<float> Assign(const LightGlueNetwork& network, LightGlueState& state,
                         Workspace& workspace) {
  const TensorView<float> scores = network.Similarity(state, workspace);
  const int64_t n0 = state.images[0].count;
  const int64_t n1 = state.images[1].count;
  const int64_t stride = scores.extent(1);
  const kernels::OpenKernels& kernels = network.kernels();
  const TensorView<float> rows = workspace.arena.Allocate<float>({n0});
  const TensorView<float> columns = workspace.arena.Allocate<float>({stride});
  constexpr int64_t kRows = 32;
  const int64_t row_parts = (n0 + kRows - 1) / kRows;
  workspace.pool.ParallelFor(row_parts + stride / kBlock, [&](int64_t part, int /*worker*/) {
    if (part < row_parts) {
      kernels.row_log_sums({.scores = scores.data(),
                            .stride = stride,
                            .columns = n1,
                            .row_begin = part * kRows,
                            .row_end = std::min(n0, (part + 1) * kRows),
                            .out = rows.data()});
    } else {
      const int64_t begin = (part - row_parts) * kBlock;
      kernels.column_log_sums({.scores = scores.data(),
                               .stride = stride,
                               .rows = n0,
                               .column_begin = begin,
                               .column_end = begin + kBlock,
                               .out = columns.data()});
    }
  });
  const auto log_matchable = [&](int image, int64_t i) {
    return LogSigmoid(state.images[static_cast<std::size_t>(image)].logits[i * kBlock]);
  };
  for (int64_t j = 0; j < n1; ++j) {
    columns[j] = log_matchable(1, j) - columns[j];
  }
  workspace.pool.ParallelFor(row_parts, [&](int64_t part, int /*worker*/) {
    for (int64_t i = part * kRows; i < std::min(n0, (part + 1) * kRows); ++i) {
      const float of_row = log_matchable(0, i) - rows[i];
      float* const row = scores.data() + i * stride;
      for (int64_t j = 0; j < n1; ++j) {
        row[j] = 2.0F * row[j] + (of_row + columns[j]);
      }
    }
  });
  return scores;
}

}  // namespace

void LightGlueOptions::Validate() const {
  CheckShare(match_threshold, "match threshold");
  CheckShare(depth_confidence, "depth confidence");
  CheckShare(width_confidence, "width confidence");
}

LightGlue::LightGlue(const Weights& weights, Isa isa) {
  const LightGlueWeights folded = ReadLightGlueWeights(weights);
  const auto size = static_cast<double>(folded.size);
  layer_flops_ = 2.0 * LayerSize(folded);
  other_flops_ = 2.0 * (size * size + size);
  if (folded.input_projection) {
    other_flops_ += 2.0 * size * static_cast<double>(folded.descriptor_size);
  }
  network_ = std::make_unique<const LightGlueNetwork>(folded, isa);
}

LightGlue::LightGlue(LightGlue&&) noexcept = default;
LightGlue& LightGlue::operator=(LightGlue&&) noexcept = default;
LightGlue::~LightGlue() = default;

int LightGlue::descriptor_size() const {
  return static_cast<int>(network_->layers().descriptor_size);
}

int LightGlue::layers() const { return static_cast<int>(network_->layers().layers.size()); }

bool LightGlue::has_adaptive_depth() const { return network_->layers().has_confidence; }

double LightGlue::Flops(int64_t keypoints0, int64_t keypoints1, int layers) const {
  const auto n0 = static_cast<double>(keypoints0);
  const auto n1 = static_cast<double>(keypoints1);
  const auto size = static_cast<double>(network_->layers().size);
  // Self-attention's two products; cross-attention's scores, once, and two products with values.
  const double attention = 2.0 * size * (2.0 * (n0 * n0 + n1 * n1) + 3.0 * n0 * n1);
  return layers * (layer_flops_ * (n0 + n1) + attention) + other_flops_ * (n0 + n1) +
         2.0 * size * n0 * n1;
}

TensorView<float> LightGlue::LogAssignment(const Features& features0, const Features& features1,
                                           Workspace& workspace) const {
  CheckFeatures(features0, descriptor_size());
  CheckFeatures(features1, descriptor_size());
  workspace.arena.Reset();
  const LightGlueOptions all = {.depth_confidence = 0.0F, .width_confidence = 0.0F};
  LightGlueState state = network_->Run(features0, features1, all, 2 * layers(), workspace);
  const TensorView<float> inner = Assign(*network_, state, workspace);
  const int64_t n0 = features0.size();
  const int64_t n1 = features1.size();
  const TensorView<float> log_assignment = workspace.arena.Allocate<float>({n0 + 1, n1 + 1});
  auto matrix = log_assignment.Matrix();
  matrix.topLeftCorner(n0, n1) = inner.Matrix().leftCols(n1);
  for (int64_t i = 0; i < n0; ++i) {
    matrix(i, n1) = LogSigmoid(-state.images[0].logits[i * kBlock]);
  }
  for (int64_t j = 0; j < n1; ++j) {
    matrix(n0, j) = LogSigmoid(-state.images[1].logits[j * kBlock]);
  }
  matrix(n0, n1) = 0.0F;
  return log_assignment;
}

void LightGlue::Match(const Features& features0, const Features& features1,
                      const LightGlueOptions& options, Workspace& workspace, Matches& matches,
                      LightGlueEffort* effort) const {
  options.Validate();
  if (options.depth_confidence > 0.0F && !has_adaptive_depth()) {
    throw Error("this LightGlue's weights cannot tell how sure it is: depth confidence must be 0");
  }
  matches.matches0.assign(static_cast<std::size_t>(features0.size()), -1);
  matches.scores0.assign(static_cast<std::size_t>(features0.size()), 0.0F);
  if (effort != nullptr) {
    effort->layers = 0;
    effort->rounds0.assign(static_cast<std::size_t>(features0.size()), 1);
    effort->rounds1.assign(static_cast<std::size_t>(features1.size()), 1);
  }
  if (features0.size() == 0 || features1.size() == 0) {
    return;
  }
  CheckFeatures(features0, descriptor_size());
  CheckFeatures(features1, descriptor_size());
  Arena& arena = workspace.arena;
  arena.Reset();
  LightGlueState state = network_->Run(features0, features1, options, 2 * layers(), workspace);
  const auto& [image0, image1] = state.images;
  if (effort != nullptr) {
    effort->layers = static_cast<int>(state.layers);
    std::copy_n(image0.rounds, features0.size(), effort->rounds0.begin());
    std::copy_n(image1.rounds, features1.size(), effort->rounds1.begin());
  }
  if (image0.count > 0 && image1.count > 0) {
    const TensorView<float> assignment = Assign(*network_, state, workspace);
    const TensorView<int32_t> best0 = arena.Allocate<int32_t>({image1.count});
    const TensorView<float> best0_score = arena.Allocate<float>({image1.count});
    std::fill_n(best0.data(), image1.count, -1);
    std::fill_n(best0_score.data(), image1.count, -std::numeric_limits<float>::infinity());
    for (int64_t i = 0; i < image0.count; ++i) {
      const float* const row = assignment.data() + i * assignment.extent(1);
      for (int64_t j = 0; j < image1.count; ++j) {
        if (row[j] > best0_score[j]) {
          best0_score[j] = row[j];
          best0[j] = static_cast<int32_t>(i);
        }
      }
    }
    for (int64_t i = 0; i < image0.count; ++i) {
      const float* const row = assignment.data() + i * assignment.extent(1);
      const int64_t best = std::max_element(row, row + image1.count) - row;
      const float score = std::exp(row[best]);
      if (best0[best] == i && score > options.match_threshold) {
        const auto keypoint = static_cast<std::size_t>(image0.indices[i]);
        matches.matches0[keypoint] = image1.indices[best];
        matches.scores0[keypoint] = std::min(score, 1.0F);
      }
    }
  }
  arena.Join();
}

}  // namespace gluevo::nn
