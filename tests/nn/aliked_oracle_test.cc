// ALIKED-n16 against the published code's outputs in double precision, stage by stage.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "aliked_network.h"
#include "gluevo/nn/aliked.h"
#include "nn/oracle_file.h"

namespace gluevo::nn {
namespace {

class AlikedOracle : public testing::TestWithParam<Isa> {
 protected:
  void SetUp() override {
    const auto oracle = OraclePath("aliked-n16");
    const auto weights = PublishedWeightsPath("aliked-n16");
    if (!oracle || !weights) {
      GTEST_SKIP() << "needs oracle_open and aliked-n16.safetensors in the folder of "
                      "GLUEVO_PUBLISHED_WEIGHTS";
    }
    oracle_ = std::make_unique<OracleFile>(*oracle);
    weights_ = ReadWeights(*weights);
    for (std::size_t i = 0; i < 2; ++i) {
      images_[i] =
          cv::imread((oracle->parent_path() / ("image" + std::to_string(i) + ".png")).string(),
                     cv::IMREAD_GRAYSCALE);
      ASSERT_FALSE(images_[i].empty());
      views_[i] = {images_[i].data, images_[i].cols, images_[i].rows,
                   static_cast<std::ptrdiff_t>(images_[i].step[0])};
    }
  }

  // The largest difference of a map from the first rows of one that is stored.
  double LargestError(const kernels::BlockedMap& map, const std::string& name) const {
    const Tensor<float>& expected = oracle_->Floats(name);
    double largest = 0.0;
    for (int64_t i = 0; i < expected.size(); ++i) {
      const int64_t x = i % expected.extent(2);
      const int64_t y = i / expected.extent(2) % expected.extent(1);
      const int64_t c = i / expected.extent(2) / expected.extent(1);
      const double actual = map.pixel(c / kernels::kBlock, y, x)[c % kernels::kBlock];
      largest = std::max(largest, std::abs(actual - expected[i]));
    }
    return largest;
  }

  // As sets: the nearest within 0.05 pixels; but for keypoints whose selection hangs on a
  // difference within the limit of scores, of which this sample has none.
  void CheckKeypoints(const Features& features, const std::string& prefix, bool descriptors) {
    SCOPED_TRACE(prefix);
    const auto keypoints = oracle_->Floats(prefix + "_keypoints").Matrix();
    const Tensor<float>& scores = oracle_->Floats(prefix + "_scores");
    ASSERT_EQ(features.size(), keypoints.rows());
    for (Eigen::Index i = 0; i < keypoints.rows(); ++i) {
      Eigen::Index nearest = 0;
      (features.keypoints.rowwise() - keypoints.row(i)).rowwise().norm().minCoeff(&nearest);
      EXPECT_NEAR(features.keypoints(nearest, 0), keypoints(i, 0), 1e-3);
      EXPECT_NEAR(features.keypoints(nearest, 1), keypoints(i, 1), 1e-3);
      EXPECT_NEAR(features.scores[nearest], scores[i], 2e-4);
      if (descriptors) {
        const auto expected = oracle_->Floats(prefix + "_descriptors").Matrix().row(i);
        EXPECT_LT((features.descriptors.row(nearest) - expected).cwiseAbs().maxCoeff(), 5e-5) << i;
      }
    }
  }

  ThreadPool pool_{2};
  std::unique_ptr<OracleFile> oracle_;
  Weights weights_;
  std::array<cv::Mat, 2> images_;
  std::array<GrayImage, 2> views_;
};

INSTANTIATE_TEST_SUITE_P(Isas, AlikedOracle, testing::ValuesIn(SupportedIsas()),
                         [](const auto& test) { return IsaName(test.param); });

// Limits: some five times the noise of fp32 against fp64 in the published code.
TEST_P(AlikedOracle, EveryStageAgrees) {
  const AlikedNetwork network(ReadAlikedWeights(weights_), GetParam());
  Workspace workspace(pool_);
  const AlikedMaps maps = network.Encode(views_[0], true, workspace);
  EXPECT_LT(LargestError(maps.blocks[0], "image0_block1_rows0to7"), 1e-4);
  EXPECT_LT(LargestError(maps.blocks[1], "image0_block2_rows0to7"), 1e-4);
  EXPECT_LT(LargestError(maps.blocks[2], "image0_block3"), 1e-4);
  EXPECT_LT(LargestError(maps.blocks[3], "image0_block4"), 1e-4);
  EXPECT_LT(LargestError(maps.offsets[0], "image0_block3_offsets1"), 1e-4);
  EXPECT_LT(LargestError(maps.offsets[1], "image0_block4_offsets1"), 1e-4);

  // Features of single pixels.
  const Tensor<float>& expected = oracle_->Floats("image0_feature_map_rows40to43");
  const int64_t width = expected.extent(2);
  std::vector<int32_t> xs;
  std::vector<int32_t> ys;
  xs.reserve(static_cast<std::size_t>(4 * width));
  ys.reserve(static_cast<std::size_t>(4 * width));
  for (int64_t i = 0; i < 4 * width; ++i) {
    xs.push_back(static_cast<int32_t>(i % width));
    ys.push_back(static_cast<int32_t>(40 + i / width));
  }
  const auto count = static_cast<int64_t>(xs.size());
  Tensor<float> rows(Shape{128 * count});
  Tensor<float> scratch(Shape{16 * count});
  network.FeaturesAt(maps,
                     {.rows = rows.data(),
                      .block_stride = count * kernels::kBlock,
                      .pixels_y = ys.data(),
                      .pixels_x = xs.data(),
                      .count = count},
                     scratch.data());
  double largest = 0.0;
  for (int64_t i = 0; i < expected.size(); ++i) {
    const int64_t c = i / count;
    const double actual =
        rows[(c / kernels::kBlock * count + i % count) * kernels::kBlock + c % kernels::kBlock];
    largest = std::max(largest, std::abs(actual - expected[i]));
  }
  EXPECT_LT(largest, 5e-5);
}

TEST_P(AlikedOracle, ScoresKeypointsAndDescriptorsAgree) {
  const Aliked aliked(weights_, GetParam());
  Workspace workspace(pool_);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string image = "image" + std::to_string(i);
    const TensorView<float> scores = aliked.Scores(views_[i], workspace);
    EXPECT_LT(
        (scores.Matrix() - oracle_->Floats(image + "_score_map").Matrix()).cwiseAbs().maxCoeff(),
        2e-4);
    Features features;
    aliked.Extract(views_[i], {}, workspace, features);
    CheckKeypoints(features, image, true);
    aliked.Extract(views_[i], {.keypoint_threshold = 0.0F, .max_keypoints = 150}, workspace,
                   features);
    CheckKeypoints(features, image + "_top150", false);
  }
  Features limited;
  aliked.Extract(views_[0], {.max_keypoints = 100}, workspace, limited);
  CheckKeypoints(limited, "image0_limit100", false);
}

}  // namespace
}  // namespace gluevo::nn
