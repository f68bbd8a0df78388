// A call of a network after the first asks the system for no memory.

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>
#include <vector>

#include "count_allocations.h"
#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"
#include "nn/golden.h"

namespace gluevo::nn {
namespace {

class SteadyStateTest : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    if (GLUEVO_COUNTS_ALLOCATIONS == 0) {
      GTEST_SKIP() << "allocations are not counted under a sanitiser";
    }
  }
  int threads() const { return GetParam(); }
};

INSTANTIATE_TEST_SUITE_P(Threads, SteadyStateTest, testing::Values(1, 2));

struct Image {
  std::vector<uint8_t> pixels;
  GrayImage view;
};

// Dark and bright rectangles: SuperPoint finds their corners.
Image RandomImage(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image image{std::vector<uint8_t>(static_cast<std::size_t>(width) * height, 100), {}};
  for (int i = 0; i < 60; ++i) {
    const int left = static_cast<int>(random() % static_cast<unsigned>(width));
    const int top = static_cast<int>(random() % static_cast<unsigned>(height));
    const auto value = static_cast<uint8_t>(random());
    for (int y = top; y < std::min(height, top + 20); ++y) {
      for (int x = left; x < std::min(width, left + 20); ++x) {
        image.pixels[static_cast<std::size_t>(y) * width + x] = value;
      }
    }
  }
  image.view = {image.pixels.data(), width, height, width};
  return image;
}

Features RandomFeatures(int count, int size, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Features features;
  features.width = 640;
  features.height = 480;
  features.keypoints.resize(count, 2);
  features.scores = Eigen::VectorXf::Constant(count, 0.5F);
  features.descriptors.resize(count, size);
  for (Eigen::Index i = 0; i < count; ++i) {
    features.keypoints(i, 0) = static_cast<float>(random() % 640);
    features.keypoints(i, 1) = static_cast<float>(random() % 480);
    for (Eigen::Index j = 0; j < size; ++j) {
      features.descriptors(i, j) = normal(random);
    }
    features.descriptors.row(i).normalize();
  }
  return features;
}

TEST_P(SteadyStateTest, AllocationsAreCounted) {
  void* volatile memory = nullptr;
  EXPECT_EQ(AllocationsOf([&] { memory = std::malloc(100); }), 1);
  std::free(memory);
  EXPECT_EQ(AllocationsOf([&] { memory = ::operator new (100, std::align_val_t{64}); }), 1);
  ::operator delete (memory, std::align_val_t{64});
  std::vector<int> vector;
  EXPECT_EQ(AllocationsOf([&] { vector.resize(50); }), 1);
}

TEST_P(SteadyStateTest, SuperPoint) {
  const SuperPoint network(OpenSuperPointWeights());
  ThreadPool pool(threads());
  Workspace workspace(pool);
  const Image image = RandomImage(200, 136, 1);
  Features features;
  const auto extract = [&] { network.Extract(image.view, {}, workspace, features); };
  EXPECT_GT(AllocationsOf(extract), 0);
  ASSERT_GT(features.size(), 20);
  EXPECT_EQ(AllocationsOf(extract), 0);
  EXPECT_EQ(AllocationsOf(extract), 0);

  Features at = features;
  const auto describe = [&] { network.Describe(image.view, workspace, at); };
  EXPECT_EQ(AllocationsOf(describe), 0);
}

// Those whose results stay in the workspace.
TEST_P(SteadyStateTest, DenseMapsAndLogAssignment) {
  ThreadPool pool(threads());
  const SuperPoint superpoint(OpenSuperPointWeights());
  Workspace workspace(pool);
  const Image image = RandomImage(200, 136, 1);
  const auto dense = [&] { superpoint.Dense(image.view, workspace); };
  EXPECT_GT(AllocationsOf(dense), 0);
  EXPECT_EQ(AllocationsOf(dense), 0);

  const SuperGlue superglue(OpenSuperGlueWeights());
  Workspace other(pool);
  const Features features0 = RandomFeatures(40, 256, 1);
  const Features features1 = RandomFeatures(30, 256, 2);
  const auto assign = [&] {
    superglue.LogAssignment(features0, features1, {.sinkhorn_iterations = 5}, other);
  };
  EXPECT_GT(AllocationsOf(assign), 0);
  EXPECT_EQ(AllocationsOf(assign), 0);
}

// What one image needs is enough for a smaller one and one with fewer keypoints, but for the
// features, which are the caller's.
TEST_P(SteadyStateTest, SuperPointOfOtherImages) {
  const SuperPoint network(OpenSuperPointWeights());
  ThreadPool pool(threads());
  Workspace workspace(pool);
  Features features;
  network.Extract(RandomImage(200, 136, 1).view, {}, workspace, features);
  for (const Image& image : {RandomImage(200, 136, 1), RandomImage(160, 120, 2)}) {
    for (const int keypoints : {20, 10}) {
      const SuperPointOptions options = {.keypoint_threshold = 0.02F, .max_keypoints = keypoints};
      Features few;
      few.keypoints.resize(keypoints, 2);
      few.scores.resize(keypoints);
      few.descriptors.resize(keypoints, network.descriptor_size());
      EXPECT_EQ(AllocationsOf([&] { network.Extract(image.view, options, workspace, few); }), 0);
      EXPECT_EQ(few.size(), keypoints);
    }
  }
}

TEST_P(SteadyStateTest, SuperGlue) {
  const SuperGlue network(OpenSuperGlueWeights());
  ThreadPool pool(threads());
  Workspace workspace(pool);
  const Features features0 = RandomFeatures(40, 256, 1);
  const Features features1 = RandomFeatures(30, 256, 2);
  const SuperGlueOptions options = {.sinkhorn_iterations = 5};
  Matches matches;
  const auto match = [&] { network.Match(features0, features1, options, workspace, matches); };
  EXPECT_GT(AllocationsOf(match), 0);
  EXPECT_EQ(AllocationsOf(match), 0);
  EXPECT_EQ(AllocationsOf(match), 0);

  // Fewer keypoints, in any proportion.
  for (const int count0 : {40, 9}) {
    for (const int count1 : {29, 1}) {
      const Features fewer0 = RandomFeatures(count0, 256, 3);
      const Features fewer1 = RandomFeatures(count1, 256, 4);
      const auto match_fewer = [&] { network.Match(fewer0, fewer1, options, workspace, matches); };
      EXPECT_EQ(AllocationsOf(match_fewer), 0) << count0 << " " << count1;
    }
  }
}

// Scratch memory is not initialised: nothing may depend on what it held.
class ScratchMemoryTest : public testing::TestWithParam<Isa> {};

INSTANTIATE_TEST_SUITE_P(Isas, ScratchMemoryTest, testing::ValuesIn(SupportedIsas()),
                         [](const auto& test) { return IsaName(test.param); });

void FillWithNan(Arena& arena) {
  arena.Reset();
  const TensorView<float> all = arena.Allocate<float>({int64_t{8} << 20});
  std::fill_n(all.data(), all.size(), std::numeric_limits<float>::quiet_NaN());
  arena.Join();
}

TEST_P(ScratchMemoryTest, SuperPointDoesNotDependOnIt) {
  const SuperPoint network(OpenSuperPointWeights(), GetParam());
  ThreadPool pool(2);
  const Image image = RandomImage(93, 75, 1);
  Workspace workspace(pool);
  std::vector<Features> results;
  for (int i = 0; i < 2; ++i) {
    FillWithNan(workspace.arena);
    network.Extract(image.view, {}, workspace, results.emplace_back());
  }
  Workspace other(pool);
  network.Extract(image.view, {}, other, results.emplace_back());
  ASSERT_GT(results[0].size(), 5);
  for (const Features& features : results) {
    EXPECT_TRUE(features.descriptors.allFinite());
    EXPECT_EQ(features.keypoints, results[0].keypoints);
    EXPECT_EQ(features.scores, results[0].scores);
    EXPECT_EQ(features.descriptors, results[0].descriptors);
  }
}

TEST_P(ScratchMemoryTest, SuperGlueDoesNotDependOnIt) {
  const SuperGlue network(OpenSuperGlueWeights(), Precision::kFloat, GetParam());
  ThreadPool pool(2);
  const Features features0 = RandomFeatures(23, 256, 1);
  const Features features1 = RandomFeatures(37, 256, 2);
  const SuperGlueOptions options = {.sinkhorn_iterations = 5};
  Workspace workspace(pool);
  FillWithNan(workspace.arena);
  const TensorView<float> first = network.LogAssignment(features0, features1, options, workspace);
  Workspace other(pool);
  const TensorView<float> second = network.LogAssignment(features0, features1, options, other);
  EXPECT_TRUE(first.Matrix().allFinite());
  EXPECT_EQ(first.Matrix(), second.Matrix());
}

}  // namespace
}  // namespace gluevo::nn
