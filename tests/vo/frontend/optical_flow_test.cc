#include "gluevo/vo/frontend/optical_flow.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "gluevo/nn/error.h"
#include "textured_views.h"

namespace gluevo::vo {
namespace {

TEST(OpticalFlowTest, FindsAPointBelowThePixelAndRefusesOnesThatDoNotReturn) {
  const FlowOptions options = {.window = 15, .levels = 1};
  const auto pyramid = [&](double x, double y) {
    return MakePyramid(testing::PatternAt(x, y), options.window, options.levels);
  };
  const std::vector<cv::Point2f> pixels = {{30.25F, 24.5F}};
  const Flow flow = FollowBothWays(pyramid(0, 0), pyramid(1.3, -0.6), pixels, pixels, options);
  ASSERT_EQ(flow.found.at(0), 1);
  EXPECT_NEAR(flow.pixels[0].x, 31.55, 0.05);
  EXPECT_NEAR(flow.pixels[0].y, 23.9, 0.05);

  // Something else in place of the pattern.
  const Flow lost = FollowBothWays(
      pyramid(0, 0), MakePyramid(cv::Mat::zeros(48, 64, CV_8UC1), options.window, options.levels),
      pixels, pixels, options);
  EXPECT_EQ(lost.found.at(0), 0);
  EXPECT_TRUE(FollowBothWays(pyramid(0, 0), pyramid(1, 0), {}, {}, options).pixels.empty());
}

TEST(OpticalFlowTest, APyramidMadeInOldMemoryIsTheSame) {
  Pyramid remade = MakePyramid(testing::PatternAt(3.0, 1.0), 15, 2);
  const unsigned char* const memory = remade[0].data;
  RemakePyramid(testing::PatternAt(1.3, -0.6), 15, 2, remade);
  EXPECT_EQ(remade[0].data, memory);
  const Pyramid made = MakePyramid(testing::PatternAt(1.3, -0.6), 15, 2);
  ASSERT_EQ(remade.size(), made.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    EXPECT_EQ(cv::norm(remade[i], made[i], cv::NORM_INF), 0.0) << i;
  }
}

TEST(OpticalFlowTest, APyramidKeepsNothingOfTheCallersBuffer) {
  // The case in which OpenCV would: an image with other pixels of its buffer all around it.
  cv::Mat buffer = testing::PatternAt(0.0, 0.0, 164, 148);
  const Pyramid pyramid = MakePyramid(buffer(cv::Rect(50, 50, 64, 48)), 15, 2);
  const cv::Mat before = pyramid[0].clone();
  buffer.setTo(0);  // The camera's next image.
  EXPECT_EQ(cv::norm(pyramid[0], before, cv::NORM_INF), 0.0);
}

TEST(OpticalFlowTest, RefusesBadOptions) {
  EXPECT_THROW((FlowOptions{.window = 2}).Validate("flow"), Error);
  EXPECT_THROW((FlowOptions{.levels = -1}).Validate("flow"), Error);
  EXPECT_THROW((FlowOptions{.max_return_distance = 0.0}).Validate("flow"), Error);
}

}  // namespace
}  // namespace gluevo::vo
