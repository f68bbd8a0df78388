// Networks of the published sizes with random weights: the fast kernels against the reference ones,
// which sum in double, and the memory that a call takes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "gluevo/nn/random_weights.h"
#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"
#include "nn/golden.h"

namespace gluevo::nn {
namespace {

constexpr double kTolerance = 1e-4;

std::vector<uint8_t> RandomImage(int width, int height) {
  std::mt19937 generator(5);
  std::vector<uint8_t> pixels(static_cast<std::size_t>(width) * height);
  std::generate(pixels.begin(), pixels.end(),
                [&] { return static_cast<uint8_t>(generator() % 256); });
  return pixels;
}

std::vector<Isa> FastIsas() {
  std::vector<Isa> isas = SupportedIsas();
  std::erase(isas, Isa::kReference);
  return isas;
}

TEST(FullSizeTest, SuperPointAgreesWithTheReference) {
  constexpr int kWidth = 92;  // No multiple of a tile's four pixels times eight.
  constexpr int kHeight = 68;
  const std::vector<uint8_t> pixels = RandomImage(kWidth, kHeight);
  const GrayImage image = {pixels.data(), kWidth, kHeight, kWidth};
  const Weights weights = RandomSuperPointWeights();
  ThreadPool pool(2);
  Workspace reference_workspace(pool);
  const SuperPoint reference(weights, Isa::kReference);
  const SuperPoint::DenseMaps expected = reference.Dense(image, reference_workspace);
  Features expected_features;
  Workspace features_workspace(pool);
  reference.Extract(image, {}, features_workspace, expected_features);
  ASSERT_GT(expected_features.size(), 20);

  for (const Isa isa : FastIsas()) {
    SCOPED_TRACE(IsaName(isa));
    Workspace workspace(pool);
    const SuperPoint network(weights, isa);
    const SuperPoint::DenseMaps maps = network.Dense(image, workspace);
    EXPECT_LT(RelativeRms(maps.scores.Matrix(), expected.scores.Matrix()), kTolerance);
    EXPECT_LT(RelativeRms(maps.descriptors.Matrix(), expected.descriptors.Matrix()), kTolerance);
    Features features;
    network.Extract(image, {}, workspace, features);
    // In another order where scores tie.
    const auto pixels_of = [](const Features& f) {
      std::set<std::pair<float, float>> set;
      for (int i = 0; i < f.size(); ++i) {
        set.emplace(f.keypoints(i, 0), f.keypoints(i, 1));
      }
      return set;
    };
    EXPECT_EQ(pixels_of(features), pixels_of(expected_features));
  }
}

TEST(FullSizeTest, SuperGlueAgreesWithTheReference) {
  std::mt19937 generator(6);
  std::normal_distribution<float> normal(0.0F, 1.0F);
  constexpr int kCount = 45;
  Features features[2];
  for (Features& f : features) {
    f.width = 640;
    f.height = 480;
    f.keypoints = Features::Points::NullaryExpr(kCount, 2,
                                                [&] { return 240.0F + 80.0F * normal(generator); });
    f.scores = Eigen::VectorXf::Constant(kCount, 0.5F);
    f.descriptors = Features::RowMajor::NullaryExpr(kCount, 256, [&] { return normal(generator); });
    f.descriptors.rowwise().normalize();
  }
  // Most keypoints of image 0 are seen in image 1 again, in the opposite order.
  for (int i = 0; i < kCount - 10; ++i) {
    features[1].keypoints.row(kCount - 1 - i) = features[0].keypoints.row(i);
    features[1].descriptors.row(kCount - 1 - i) = features[0].descriptors.row(i);
  }
  const Weights weights = RandomSuperGlueWeights();
  ThreadPool pool(2);
  Workspace workspace(pool);
  const SuperGlueOptions options = {.match_threshold = 0.01F};
  Matches expected;
  SuperGlue(weights, Precision::kFloat, Isa::kReference)
      .Match(features[0], features[1], options, workspace, expected);
  ASSERT_GT(std::count_if(expected.matches0.begin(), expected.matches0.end(),
                          [](int match) { return match >= 0; }),
            20);
  for (const Isa isa : FastIsas()) {
    SCOPED_TRACE(IsaName(isa));
    Matches matches;
    SuperGlue(weights, Precision::kFloat, isa)
        .Match(features[0], features[1], options, workspace, matches);
    EXPECT_EQ(matches.matches0, expected.matches0);
    for (int i = 0; i < kCount; ++i) {
      EXPECT_NEAR(matches.scores0[i], expected.scores0[i], kTolerance) << i;
    }
  }
}

// By hand, from the papers' tables of layers.
TEST(FullSizeTest, OperationsAreCountedAsPublished) {
  // Multiply-adds a pixel of each resolution: 1a and 1b, 2, 3, 4 and the heads.
  const double a_pixel = 9.0 * 64 * (1 + 64) + 2 * 9.0 * 64 * 64 / 4 + 9.0 * 128 * (64 + 128) / 16 +
                         (9.0 * 128 * (2 * 128 + 2 * 256) + 256.0 * (65 + 256)) / 64;
  EXPECT_DOUBLE_EQ(SuperPoint(RandomSuperPointWeights()).Flops(752, 480),
                   2.0 * a_pixel * 752 * 480);

  const SuperGlue network(RandomSuperGlueWeights(5));
  ASSERT_EQ(network.layers(), 5);
  const double encoder = 3.0 * 32 + 32 * 64 + 64 * 128 + 128 * 256 + 256 * 256;
  const double layer = 4.0 * 256 * 256 + 512.0 * 512 + 512 * 256;
  const double keypoint = encoder + 5 * layer + 256 * 256;
  // Layers 0, 2 and 4 attend to their own image.
  const double attention = 2.0 * 256 * (3 * (300.0 * 300 + 200 * 200) + 2 * 2 * 300.0 * 200);
  EXPECT_DOUBLE_EQ(network.Flops(300, 200), 2.0 * (500 * keypoint + attention + 256 * 300.0 * 200));
}

TEST(FullSizeTest, SuperPointTakesAtMost120MegabytesBesideItsWeights) {
  constexpr int kWidth = 752;
  constexpr int kHeight = 480;
  const std::vector<uint8_t> pixels = RandomImage(kWidth, kHeight);
  const SuperPoint network(RandomSuperPointWeights());
  ThreadPool pool(2);
  Workspace workspace(pool);
  Features features;
  network.Extract({pixels.data(), kWidth, kHeight, kWidth}, {}, workspace, features);
  EXPECT_GT(features.size(), 100);
  EXPECT_LT(workspace.arena.capacity() + workspace.candidates.capacity() * sizeof(int64_t),
            120U << 20);
}

}  // namespace
}  // namespace gluevo::nn
