#include "gluevo/vo/frontend/optical_flow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

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

TEST(OpticalFlowTest, SaysHowFarOffNoisePutsAPatch) {
  constexpr int kWindow = 11;
  std::mt19937_64 generator(5U);
  std::vector<cv::Point2f> pixels;
  for (float y = 20.0F; y < 220.0F; y += 20.0F) {
    for (float x = 20.0F; x < 300.0F; x += 20.0F) {
      pixels.emplace_back(x, y);
    }
  }
  const auto noisy = [&](double shift, double sigma) {
    cv::Mat image = testing::PatternAt(shift, 0.0, 320, 240);
    std::normal_distribution<double> noise(0.0, sigma);
    for (auto pixel = image.begin<unsigned char>(); pixel != image.end<unsigned char>(); ++pixel) {
      *pixel = static_cast<unsigned char>(
          std::clamp(static_cast<double>(*pixel) + noise(generator), 0.0, 255.0));
    }
    return MakePyramid(image, kWindow, 0);
  };
  double before = 0.0;
  for (const double sigma : {2.0, 6.0}) {
    const Pyramid from = noisy(0.0, sigma);
    const Pyramid to = noisy(0.4, sigma);
    const Flow flow = FollowBothWays(from, to, pixels, pixels, {kWindow, 0, 0, 0.5});
    std::vector<double> misses;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (flow.found[i] != 0) {
        misses.push_back((flow.pixels[i] - pixels[i] - cv::Point2f(0.4F, 0.0F)).x);
      }
    }
    ASSERT_GT(misses.size(), 100U);
    double sum = 0.0;
    for (const double miss : misses) {
      sum += miss * miss;
    }
    const double rms = std::sqrt(sum / static_cast<double>(misses.size()));
    const double expected = MedianFlowSigma(from, pixels, flow, kWindow);
    // Along the worse axis; the x axis is a mixture.
    EXPECT_LT(rms, 1.3 * expected);
    EXPECT_GT(rms, 0.4 * expected);
    EXPECT_GT(expected, 2.0 * before);
    before = expected;
  }
  const Pyramid flat = MakePyramid(cv::Mat::zeros(240, 320, CV_8UC1), kWindow, 0);
  const Flow nothing = {pixels, std::vector<unsigned char>(pixels.size(), 0)};
  EXPECT_TRUE(std::isinf(MedianFlowSigma(flat, pixels, nothing, kWindow)));
}

TEST(OpticalFlowTest, RefusesBadOptions) {
  EXPECT_THROW((FlowOptions{.window = 2}).Validate("flow"), Error);
  EXPECT_THROW((FlowOptions{.levels = -1}).Validate("flow"), Error);
  EXPECT_THROW((FlowOptions{.max_return_distance = 0.0}).Validate("flow"), Error);
}

}  // namespace
}  // namespace gluevo::vo
