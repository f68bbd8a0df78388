// How deep a key frame's keypoints are: by optical flow, or by the network where that fails.

#include "keyframe_views.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "gluevo/vo/frontend/network_matcher.h"

namespace gluevo::vo {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kFocal = 200.0;
constexpr double kBaseline = 0.1;
constexpr double kDisparity = 8.0;

StereoRig LevelRig() {
  StereoRig rig;
  for (Camera& camera : rig.cameras) {
    camera = {kWidth, kHeight, kFocal, kFocal, 159.5, 119.5};
  }
  rig.body_from_cam[1].translation.x() = kBaseline;
  return rig;
}

cv::Mat Noise(uint64_t seed) {
  cv::Mat image(kHeight, kWidth, CV_8UC1);
  cv::RNG(seed).fill(image, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(image, image, {}, 2.0);
  return image;
}

// As seen by the right camera where all is equally far.
cv::Mat Shifted(const cv::Mat& left) {
  const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, -kDisparity, 0, 1, 0);
  cv::Mat right;
  cv::warpAffine(left, right, shift, left.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
  return right;
}

// A grid in each image, one disparity apart; counts the images.
class GridExtractor final : public FeatureExtractor {
 public:
  nn::Features Extract(const cv::Mat& image) override {
    const double shift = images++ == 0 ? 0.0 : kDisparity;
    nn::Features features{.width = image.cols, .height = image.rows};
    constexpr int kSide = 10;
    features.keypoints.resize(kSide * kSide, 2);
    features.scores.setOnes(kSide * kSide);
    features.descriptors.setIdentity(kSide * kSide, kSide * kSide);
    for (int i = 0; i < kSide * kSide; ++i) {
      const int row = i / kSide;
      features.keypoints.row(i) << static_cast<float>(40 + 25 * (i % kSide) - shift),
          static_cast<float>(20 + 21 * row);
    }
    return features;
  }
  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& /*pixels*/) override {
    return Extract(image);
  }
  int images = 0;
};

LoopKeyframe Find(const cv::Mat& left, const cv::Mat& right, GridExtractor& extractor) {
  LoopKeyframe keyframe;
  internal::FindKeypoints({0, {left, right}}, {}, LevelRig(), extractor,
                          *MakeNearestNeighborMatcher(), 0.5F, keyframe);
  return keyframe;
}

int CountDeep(const LoopKeyframe& keyframe) {
  constexpr double kInverseDepth = kDisparity / (kFocal * kBaseline);
  return static_cast<int>(std::count_if(
      keyframe.keypoints.begin(), keyframe.keypoints.end(), [&](const StereoKeypoint& keypoint) {
        return std::abs(keypoint.inverse_depth / kInverseDepth - 1.0) < 0.02;
      }));
}

TEST(KeyframeViews, TheNetworkLooksAtOneImageWhereOpticalFlowFindsTheOther) {
  GridExtractor extractor;
  const cv::Mat left = Noise(1);
  const LoopKeyframe keyframe = Find(left, Shifted(left), extractor);
  EXPECT_EQ(extractor.images, 1);
  EXPECT_GE(CountDeep(keyframe), 95);
}

TEST(KeyframeViews, TheNetworkLooksAtBothWhereItDoesNot) {
  GridExtractor extractor;
  const LoopKeyframe keyframe = Find(Noise(1), Noise(2), extractor);
  EXPECT_EQ(extractor.images, 2);
  EXPECT_EQ(CountDeep(keyframe), 100);
}

TEST(KeyframeViews, ASingleImageHasNoDepths) {
  GridExtractor extractor;
  const LoopKeyframe keyframe = Find(Noise(1), {}, extractor);
  EXPECT_EQ(extractor.images, 1);
  ASSERT_EQ(keyframe.keypoints.size(), 100U);
  EXPECT_EQ(CountDeep(keyframe), 0);
}

}  // namespace
}  // namespace gluevo::vo
