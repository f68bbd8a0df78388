#include "gluevo/vo/frontend/network_memo.h"

#include <gtest/gtest.h>

namespace gluevo::vo {
namespace {

// Counts its calls; its keypoint tells the image's first pixel.
class CountingExtractor final : public FeatureExtractor {
 public:
  explicit CountingExtractor(int& calls) : calls_(calls) {}
  nn::Features Extract(const cv::Mat& image) override {
    ++calls_;
    nn::Features features;
    features.keypoints.setConstant(1, 2, static_cast<float>(image.at<uchar>(0, 0)));
    return features;
  }
  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& /*pixels*/) override {
    return Extract(image);
  }

 private:
  int& calls_;
};

float Extracted(FeatureExtractor& extractor, const cv::Mat& image) {
  return extractor.Extract(image).keypoints(0, 0);
}

TEST(ExtractorMemo, AnswersForTheNewestTwoImagesWithoutWork) {
  int calls = 0;
  ExtractorMemo memo(std::make_unique<CountingExtractor>(calls));
  const cv::Mat left(8, 8, CV_8UC1, cv::Scalar(1));
  const cv::Mat right(8, 8, CV_8UC1, cv::Scalar(2));
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(Extracted(memo, left), 1.0F);
    EXPECT_EQ(Extracted(memo, right), 2.0F);
  }
  EXPECT_EQ(calls, 2);
}

TEST(ExtractorMemo, SeesThatABufferIsUsedAgain) {
  int calls = 0;
  ExtractorMemo memo(std::make_unique<CountingExtractor>(calls));
  cv::Mat image(8, 8, CV_8UC1, cv::Scalar(1));
  EXPECT_EQ(Extracted(memo, image), 1.0F);
  image.setTo(cv::Scalar(3));
  EXPECT_EQ(Extracted(memo, image), 3.0F);
  EXPECT_EQ(calls, 2);
}

TEST(ExtractorMemo, ForgetsOlderImages) {
  int calls = 0;
  ExtractorMemo memo(std::make_unique<CountingExtractor>(calls));
  for (int value = 1; value <= 3; ++value) {
    Extracted(memo, cv::Mat(8, 8, CV_8UC1, cv::Scalar(value)));
  }
  EXPECT_EQ(Extracted(memo, cv::Mat(8, 8, CV_8UC1, cv::Scalar(1))), 1.0F);
  EXPECT_EQ(calls, 4);
}

TEST(SharedExtractor, HasOneOwnerMore) {
  int calls = 0;
  const auto memo = std::make_shared<ExtractorMemo>(std::make_unique<CountingExtractor>(calls));
  SharedExtractor front_end(memo);
  SharedExtractor loops(memo);
  const cv::Mat image(8, 8, CV_8UC1, cv::Scalar(5));
  EXPECT_EQ(Extracted(front_end, image), Extracted(loops, image));
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace gluevo::vo
