#include "gluevo/nn/aliked.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "aliked_network.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/nn/superpoint.h"

namespace gluevo::nn {
namespace {

constexpr int kRadius = 2;  // Of non-maximum suppression, refinement and the border.
constexpr float kTemperature = 0.1F;
constexpr int kLeastSide = 8;

void CheckImage(const GrayImage& image) {
  if (image.width < kLeastSide || image.height < kLeastSide) {
    throw Error("an image of " + std::to_string(image.width) + " x " +
                std::to_string(image.height) + " pixels: ALIKED needs at least 8 x 8");
  }
}

// Differentiable keypoint detection (Zhao et al. 2022): the mean of the positions around a peak,
// weighted by the softmax of their scores.
Eigen::RowVector2f Refined(TensorView<const float> scores, int64_t x, int64_t y) {
  const auto at = [&](int64_t u, int64_t v) { return scores[v * scores.extent(1) + u]; };
  float largest = at(x, y);
  for (int64_t v = y - kRadius; v <= y + kRadius; ++v) {
    for (int64_t u = x - kRadius; u <= x + kRadius; ++u) {
      largest = std::max(largest, at(u, v));
    }
  }
  float sum = 0.0F;
  Eigen::RowVector2f offset = Eigen::RowVector2f::Zero();
  for (int64_t v = -kRadius; v <= kRadius; ++v) {
    for (int64_t u = -kRadius; u <= kRadius; ++u) {
      const float weight = std::exp((at(x + u, y + v) - largest) / kTemperature);
      sum += weight;
      offset += weight * Eigen::RowVector2f(static_cast<float>(u), static_cast<float>(v));
    }
  }
  return Eigen::RowVector2f(static_cast<float>(x), static_cast<float>(y)) + offset / sum;
}

// The score map between four pixels.
float ScoreAt(TensorView<const float> scores, const Eigen::RowVector2f& position) {
  const int64_t x = std::min(static_cast<int64_t>(position.x()), scores.extent(1) - 2);
  const int64_t y = std::min(static_cast<int64_t>(position.y()), scores.extent(0) - 2);
  const float right = position.x() - static_cast<float>(x);
  const float below = position.y() - static_cast<float>(y);
  const float* const row = scores.data() + y * scores.extent(1) + x;
  const float* const next = row + scores.extent(1);
  return (1.0F - below) * ((1.0F - right) * row[0] + right * row[1]) +
         below * ((1.0F - right) * next[0] + right * next[1]);
}

}  // namespace

void AlikedOptions::Validate() const {
  if (!(keypoint_threshold >= 0.0F && keypoint_threshold < 1.0F)) {
    throw OptionError("keypoint threshold " + std::to_string(keypoint_threshold) +
                      " is out of range: expected 0 or more and below 1");
  }
  if (max_keypoints < 1) {
    throw OptionError("maximum number of keypoints " + std::to_string(max_keypoints) +
                      " is out of range: expected at least 1");
  }
}

Aliked::Aliked(const Weights& weights, Isa isa)
    : network_(std::make_unique<const AlikedNetwork>(ReadAlikedWeights(weights), isa)) {}
Aliked::Aliked(Aliked&&) noexcept = default;
Aliked& Aliked::operator=(Aliked&&) noexcept = default;
Aliked::~Aliked() = default;

int Aliked::descriptor_size() const { return static_cast<int>(network_->layers().size); }

double Aliked::Flops(int width, int height, int keypoints) const {
  const AlikedLayers& layers = network_->layers();
  const auto [c1, c2, c3, c4] = layers.widths;
  const int64_t size = layers.size;
  const auto deformable_block = [](int64_t in, int64_t out) {
    return 9 * (18 + out) * (in + out) + in * out;
  };
  int64_t score_head = size * layers.score_channels;
  for (const Tensor<float>& weights : layers.score_layers) {
    score_head += weights.size();
  }
  const auto per = [](int64_t multiply_adds, int64_t pixels) {
    return static_cast<double>(multiply_adds) / static_cast<double>(pixels);
  };
  const double pixel = static_cast<double>(9 * c1 + 9 * c1 * c1 + c1 * size / 4 + score_head) +
                       per(9 * c1 * c2 + 9 * c2 * c2 + c1 * c2 + c2 * size / 4, 4) +
                       per(deformable_block(c2, c3) + c3 * size / 4, 64) +
                       per(deformable_block(c3, c4) + c4 * size / 4, 1024);
  const int64_t samples = layers.samples;
  const int64_t keypoint = 2 * samples * (9 * size + 2 * samples) + 2 * samples * size * size;
  const auto padded = [](int side) { return static_cast<double>((side + 31) / 32 * 32); };
  return 2.0 * (pixel * padded(width) * padded(height) + static_cast<double>(keypoint) * keypoints);
}

TensorView<float> Aliked::Scores(const GrayImage& image, Workspace& workspace) const {
  CheckImage(image);
  workspace.arena.Reset();
  return network_->Scores(network_->Encode(image, true, workspace), workspace);
}

void Aliked::Extract(const GrayImage& image, const AlikedOptions& options, Workspace& workspace,
                     Features& features) const {
  options.Validate();
  CheckImage(image);
  workspace.arena.Reset();
  const AlikedMaps maps = network_->Encode(image, true, workspace);
  const TensorView<float> scores = network_->Scores(maps, workspace);
  std::vector<int64_t>& selected = workspace.candidates;
  SelectKeypoints(scores,
                  {.keypoint_threshold = options.keypoint_threshold,
                   .nms_radius = kRadius,
                   .border = kRadius,
                   .max_keypoints = options.max_keypoints},
                  workspace, selected);
  features.width = image.width;
  features.height = image.height;
  features.keypoints.resize(static_cast<Eigen::Index>(selected.size()), 2);
  features.scores.resize(static_cast<Eigen::Index>(selected.size()));
  for (std::size_t i = 0; i < selected.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Eigen::RowVector2f position =
        Refined(scores, selected[i] % image.width, selected[i] / image.width);
    features.keypoints.row(row) = position;
    features.scores[row] = ScoreAt(scores, position);
  }
  network_->Describe(maps, workspace, features);
  workspace.arena.Join();
}

void Aliked::Describe(const GrayImage& image, Workspace& workspace, Features& features) const {
  CheckImage(image);
  workspace.arena.Reset();
  features.width = image.width;
  features.height = image.height;
  features.scores.resize(0);
  network_->Describe(network_->Encode(image, false, workspace), workspace, features);
  workspace.arena.Join();
}

}  // namespace gluevo::nn
