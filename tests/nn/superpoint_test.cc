#include "gluevo/nn/superpoint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "nn/golden.h"

namespace gluevo::nn {
namespace {

struct Image {
  std::vector<uint8_t> pixels;
  GrayImage view;
};

Image GoldenImage(const Weights& golden) {
  const Tensor<float>& values = golden.Get("image");
  Image image;
  for (int64_t i = 0; i < values.size(); ++i) {
    image.pixels.push_back(static_cast<uint8_t>(values[i]));
  }
  image.view = {image.pixels.data(), static_cast<int>(values.extent(1)),
                static_cast<int>(values.extent(0)), values.extent(1)};
  return image;
}

class SuperPointGolden : public testing::TestWithParam<std::pair<Isa, const char*>> {};

TEST_P(SuperPointGolden, DenseMapsKeypointsAndDescriptorsAgree) {
  const auto& [isa, name] = GetParam();
  const Weights golden = ReadGolden(name);
  const Image image = GoldenImage(golden);
  const SuperPoint network(OpenSuperPointWeights(), isa);
  ThreadPool pool(2);
  Workspace workspace(pool);

  const SuperPoint::DenseMaps maps = network.Dense(image.view, workspace);
  CheckShape(maps.scores.shape(), golden.Get("score_map").shape(), "score map");
  EXPECT_LT(RelativeRms(maps.scores.Matrix(), golden.Get("score_map").Matrix()), kNetworkTolerance);
  // The golden map is [D x h x w].
  const auto descriptors =
      golden.Get("descriptor_map")
          .view()
          .Reshaped({network.descriptor_size(), maps.descriptors.Matrix().rows()})
          .Matrix()
          .transpose()
          .eval();
  EXPECT_LT(RelativeRms(maps.descriptors.Matrix(), descriptors), kNetworkTolerance);

  Features features;
  network.Extract(image.view, {.max_keypoints = 100000}, workspace, features);
  EXPECT_EQ(features.width, image.view.width);
  EXPECT_EQ(features.height, image.view.height);
  const auto expected = golden.Get("keypoints").Matrix();
  ASSERT_EQ(features.size(), expected.rows());
  ASSERT_GT(features.size(), 20);
  std::map<std::pair<float, float>, int> index_of;
  for (int i = 0; i < features.size(); ++i) {
    index_of[{features.keypoints(i, 0), features.keypoints(i, 1)}] = i;
    EXPECT_TRUE(i == 0 || features.scores[i - 1] >= features.scores[i]);
  }
  for (int row = 0; row < expected.rows(); ++row) {
    const auto found = index_of.find({expected(row, 0), expected(row, 1)});
    ASSERT_NE(found, index_of.end()) << "keypoint " << expected.row(row) << " is missing";
    EXPECT_NEAR(features.scores[found->second], golden.Get("scores")[row], 1e-5);
    EXPECT_LT(
        (features.descriptors.row(found->second) - golden.Get("descriptors").Matrix().row(row))
            .norm(),
        2.0 * kNetworkTolerance);
  }
}

std::vector<std::pair<Isa, const char*>> AllGolden() {
  std::vector<std::pair<Isa, const char*>> all;
  for (const Isa isa : SupportedIsas()) {
    all.emplace_back(isa, "golden_superpoint_120x88");
    all.emplace_back(isa, "golden_superpoint_101x67");
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Isas, SuperPointGolden, testing::ValuesIn(AllGolden()),
                         [](const auto& test) {
                           return IsaName(test.param.first) +
                                  std::string(test.param.second).substr(17);
                         });

TEST(SuperPointTest, IsTheSameForAnyNumberOfThreads) {
  const Image image = GoldenImage(ReadGolden("golden_superpoint_120x88"));
  const SuperPoint network(OpenSuperPointWeights());
  std::vector<Features> results;
  for (const int threads : {1, 2, 3, 5}) {
    ThreadPool pool(threads);
    Workspace workspace(pool);
    network.Extract(image.view, {}, workspace, results.emplace_back());
  }
  for (const Features& other : results) {
    EXPECT_EQ(other.keypoints, results[0].keypoints);
    EXPECT_EQ(other.scores, results[0].scores);
    EXPECT_EQ(other.descriptors, results[0].descriptors);
  }
}

TEST(SuperPointTest, KeepsTheBestKeypoints) {
  const Image image = GoldenImage(ReadGolden("golden_superpoint_120x88"));
  const SuperPoint network(OpenSuperPointWeights());
  ThreadPool pool(1);
  Workspace workspace(pool);
  Features all;
  Features some;
  network.Extract(image.view, {}, workspace, all);
  network.Extract(image.view, {.max_keypoints = 10}, workspace, some);
  ASSERT_EQ(some.size(), 10);
  EXPECT_EQ(some.keypoints, all.keypoints.topRows(10));
  EXPECT_EQ(some.descriptors, all.descriptors.topRows(10));
}

TEST(SuperPointTest, DescribesGivenPositionsLikeItsOwnKeypoints) {
  const Image image = GoldenImage(ReadGolden("golden_superpoint_120x88"));
  const SuperPoint network(OpenSuperPointWeights());
  ThreadPool pool(1);
  Workspace workspace(pool);
  Features extracted;
  network.Extract(image.view, {}, workspace, extracted);
  Features given;
  given.keypoints = extracted.keypoints;
  network.Describe(image.view, workspace, given);
  EXPECT_EQ(given.descriptors, extracted.descriptors);
  EXPECT_EQ(given.scores.size(), 0);
  EXPECT_EQ(given.width, image.view.width);
  EXPECT_EQ(given.height, image.view.height);

  given.keypoints.resize(2, 2);
  given.keypoints << -50.0F, -50.0F, 1e6F, 1e6F;  // Outside: the corners' cells.
  network.Describe(image.view, workspace, given);
  const SuperPoint::DenseMaps maps = network.Dense(image.view, workspace);
  const auto cells = maps.descriptors.Matrix();
  EXPECT_LT((given.descriptors.row(0) - cells.row(0)).norm(), 1e-6);
  EXPECT_LT((given.descriptors.row(1) - cells.row(cells.rows() - 1)).norm(), 1e-6);
}

// The detector is not run: it takes no room, however wide it is, and changes nothing.
TEST(SuperPointTest, DescribesWithoutTheDetector) {
  const Image image = GoldenImage(ReadGolden("golden_superpoint_120x88"));
  const Weights weights = OpenSuperPointWeights();
  Weights wide = weights;
  constexpr int64_t kWide = 2048;
  const int64_t channels = weights.Get("convPa.weight").extent(1);
  wide.tensors["convPa.weight"] = Tensor<float>({kWide, channels, 3, 3});
  wide.tensors["convPa.bias"] = Tensor<float>(Shape{kWide});
  wide.tensors["convPb.weight"] = Tensor<float>({65, kWide, 1, 1});
  wide.tensors.erase("convPa.scale");
  wide.tensors.erase("convPa.shift");
  ThreadPool pool(1);
  std::vector<Features> described(2);
  std::vector<std::size_t> bytes_to_describe;
  std::vector<std::size_t> bytes_to_extract;
  for (std::size_t i = 0; i < 2; ++i) {
    const SuperPoint network(i == 0 ? weights : wide);
    Workspace workspace(pool);
    described[i].keypoints.resize(2, 2);
    described[i].keypoints << 20.0F, 31.5F, 90.0F, 70.0F;
    network.Describe(image.view, workspace, described[i]);
    bytes_to_describe.push_back(workspace.arena.capacity());
    Workspace other(pool);
    Features extracted;
    network.Extract(image.view, {}, other, extracted);
    bytes_to_extract.push_back(other.arena.capacity());
  }
  EXPECT_EQ(described[0].descriptors, described[1].descriptors);
  EXPECT_EQ(bytes_to_describe[0], bytes_to_describe[1]);
  EXPECT_LT(bytes_to_extract[0], bytes_to_extract[1]);
  // Neither a score map.
  EXPECT_LT(bytes_to_describe[0] + 120 * 88 * sizeof(float), bytes_to_extract[0]);
}

TEST(SuperPointTest, RefusesTinyImagesBadOptionsAndOtherWeights) {
  const SuperPoint network(OpenSuperPointWeights());
  ThreadPool pool(1);
  Workspace workspace(pool);
  Features features;
  const std::vector<uint8_t> pixels(64 * 7);
  EXPECT_THROW(network.Extract({pixels.data(), 64, 7, 64}, {}, workspace, features), Error);
  EXPECT_THROW((SuperPointOptions{.keypoint_threshold = 1.5F}).Validate(), Error);
  EXPECT_THROW((SuperPointOptions{.max_keypoints = 0}).Validate(), Error);
  try {
    const SuperPoint wrong(OpenSuperGlueWeights());
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("these are a SuperGlue's"), std::string::npos);
  }
}

TEST(SuperPointTest, WorksOnTheSmallestImage) {
  const SuperPoint network(OpenSuperPointWeights());
  ThreadPool pool(2);
  Workspace workspace(pool);
  const std::vector<uint8_t> pixels(8 * 8, 100);
  const SuperPoint::DenseMaps maps = network.Dense({pixels.data(), 8, 8, 8}, workspace);
  EXPECT_EQ(maps.scores.shape(), (Shape{8, 8}));
  EXPECT_LE(maps.scores.Matrix().sum(), 1.0F + 1e-5F);
  EXPECT_NEAR(maps.descriptors.Matrix().norm(), 1.0F, 1e-5F);
}

}  // namespace
}  // namespace gluevo::nn
