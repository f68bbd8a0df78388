// As steady_state_test.cc, of ALIKED and LightGlue.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "count_allocations.h"
#include "gluevo/nn/aliked.h"
#include "gluevo/nn/lightglue.h"
#include "gluevo/nn/random_weights.h"

namespace gluevo::nn {
namespace {

class OpenNetworksSteadyState : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    if (GLUEVO_COUNTS_ALLOCATIONS == 0) {
      GTEST_SKIP() << "allocations are not counted under a sanitiser";
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Threads, OpenNetworksSteadyState, testing::Values(1, 2));

std::vector<uint8_t> RandomPixels(int width, int height) {
  std::mt19937 random(3);
  std::vector<uint8_t> pixels(static_cast<std::size_t>(width) * height);
  std::generate(pixels.begin(), pixels.end(), [&] { return static_cast<uint8_t>(random()); });
  return pixels;
}

Features RandomFeatures(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Features features;
  features.width = 640;
  features.height = 480;
  features.keypoints.resize(count, 2);
  features.descriptors.resize(count, 128);
  for (Eigen::Index i = 0; i < count; ++i) {
    features.keypoints(i, 0) = static_cast<float>(random() % 640);
    features.keypoints(i, 1) = static_cast<float>(random() % 480);
    for (Eigen::Index j = 0; j < 128; ++j) {
      features.descriptors(i, j) = normal(random);
    }
    features.descriptors.row(i).normalize();
  }
  return features;
}

TEST_P(OpenNetworksSteadyState, Aliked) {
  const Aliked network(RandomAlikedWeights());
  ThreadPool pool(GetParam());
  Workspace workspace(pool);
  const std::vector<uint8_t> pixels = RandomPixels(150, 90);
  const GrayImage image = {pixels.data(), 150, 90, 150};
  Features features;
  const AlikedOptions options = {.keypoint_threshold = 0.0F, .max_keypoints = 60};
  const auto extract = [&] { network.Extract(image, options, workspace, features); };
  EXPECT_GT(AllocationsOf(extract), 0);
  ASSERT_EQ(features.size(), 60);
  EXPECT_EQ(AllocationsOf(extract), 0);
  EXPECT_EQ(AllocationsOf(extract), 0);
  features.scores.resize(0);
  EXPECT_EQ(AllocationsOf([&] { network.Describe(image, workspace, features); }), 0);
  // A smaller image.
  const GrayImage part = {pixels.data(), 100, 60, 150};
  features.scores.resize(60);
  EXPECT_EQ(AllocationsOf([&] { network.Extract(part, options, workspace, features); }), 0);
}

TEST_P(OpenNetworksSteadyState, LightGlue) {
  const LightGlue network(RandomLightGlueWeights(3));
  ThreadPool pool(GetParam());
  Workspace workspace(pool);
  const Features features0 = RandomFeatures(70, 1);
  const Features features1 = RandomFeatures(50, 2);
  Matches matches;
  LightGlueEffort effort;
  const auto match = [&] { network.Match(features0, features1, {}, workspace, matches, &effort); };
  EXPECT_GT(AllocationsOf(match), 0);
  EXPECT_EQ(AllocationsOf(match), 0);
  EXPECT_EQ(AllocationsOf(match), 0);
  for (const int count0 : {70, 9}) {
    for (const int count1 : {49, 1}) {
      const Features fewer0 = RandomFeatures(count0, 3);
      const Features fewer1 = RandomFeatures(count1, 4);
      EXPECT_EQ(
          AllocationsOf([&] { network.Match(fewer0, fewer1, {}, workspace, matches, &effort); }), 0)
          << count0 << " " << count1;
    }
  }
}

// Scratch memory is not initialised: nothing may depend on what it held.
class OpenNetworksScratchMemory : public testing::TestWithParam<Isa> {};

INSTANTIATE_TEST_SUITE_P(Isas, OpenNetworksScratchMemory, testing::ValuesIn(SupportedIsas()),
                         [](const auto& test) { return IsaName(test.param); });

void FillWithNan(Arena& arena) {
  arena.Reset();
  const TensorView<float> all = arena.Allocate<float>({int64_t{8} << 20});
  std::fill_n(all.data(), all.size(), std::numeric_limits<float>::quiet_NaN());
  arena.Join();
}

TEST_P(OpenNetworksScratchMemory, AlikedDoesNotDependOnIt) {
  const Aliked network(RandomAlikedWeights({8, 16, 32, 64}, 64), GetParam());
  ThreadPool pool(2);
  const std::vector<uint8_t> pixels = RandomPixels(77, 51);
  const GrayImage image = {pixels.data(), 77, 51, 77};
  const AlikedOptions options = {.keypoint_threshold = 0.0F, .max_keypoints = 40};
  Workspace workspace(pool);
  std::vector<Features> results;
  for (int i = 0; i < 2; ++i) {
    FillWithNan(workspace.arena);
    network.Extract(image, options, workspace, results.emplace_back());
  }
  Workspace other(pool);
  network.Extract(image, options, other, results.emplace_back());
  ASSERT_GT(results[0].size(), 5);
  for (const Features& features : results) {
    EXPECT_TRUE(features.descriptors.allFinite());
    EXPECT_EQ(features.keypoints, results[0].keypoints);
    EXPECT_EQ(features.scores, results[0].scores);
    EXPECT_EQ(features.descriptors, results[0].descriptors);
  }
}

TEST_P(OpenNetworksScratchMemory, LightGlueDoesNotDependOnIt) {
  // Of sizes that fill no whole blocks.
  const LightGlue network(RandomLightGlueWeights(2, 128, 40, 2), GetParam());
  ThreadPool pool(2);
  const Features features0 = RandomFeatures(23, 1);
  const Features features1 = RandomFeatures(37, 2);
  Workspace workspace(pool);
  FillWithNan(workspace.arena);
  const TensorView<float> first = network.LogAssignment(features0, features1, workspace);
  Workspace other(pool);
  const TensorView<float> second = network.LogAssignment(features0, features1, other);
  EXPECT_TRUE(first.Matrix().allFinite());
  EXPECT_EQ(first.Matrix(), second.Matrix());
}

}  // namespace
}  // namespace gluevo::nn
