#include "gluevo/vo/pipeline/keypoint_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/median.h"

namespace gluevo::vo {
namespace {

// Of points whose two coordinates are off by `sigma_px`, `share_wrong` of them by anything.
double MedianErrorPx(double sigma_px, double share_wrong, std::mt19937& generator) {
  std::normal_distribution<double> error(0.0, sigma_px);
  std::uniform_real_distribution<double> anywhere(10.0, 100.0);
  constexpr int kPoints = 300;
  std::vector<double> errors;
  errors.reserve(kPoints);
  for (int i = 0; i < kPoints; ++i) {
    errors.push_back(i < share_wrong * kPoints ? anywhere(generator)
                                               : std::hypot(error(generator), error(generator)));
  }
  return Median(std::move(errors));
}

double AfterFrames(KeypointNoise noise, double sigma_px, double share_wrong) {
  std::mt19937 generator(7);
  for (int frame = 0; frame < 100; ++frame) {
    noise.Learn(MedianErrorPx(sigma_px, share_wrong, generator));
  }
  return noise.px();
}

TEST(KeypointNoise, IsWhatFramesSay) {
  for (const double margin : {1.0, 1.4}) {
    const KeypointNoise start(1.5, {.least_px = 0.1, .largest_px = 10.0, .margin = margin});
    for (const double sigma_px : {0.3, 1.0, 4.0}) {
      // 300 points leave a median uncertain by 6 %; of frames before some three count.
      EXPECT_NEAR(AfterFrames(start, sigma_px, 0.0), margin * sigma_px, 0.15 * sigma_px);
    }
  }
}

TEST(KeypointNoise, HardlyHeedsWrongMatches) {
  // The median of all is then that quantile of the right ones at which they are 0.5 / 0.75.
  const double factor = std::sqrt(std::log(3.0) / std::log(2.0));
  const KeypointNoise start(1.5, {.least_px = 0.1, .largest_px = 10.0, .margin = 1.0});
  EXPECT_NEAR(AfterFrames(start, 1.0, 0.25), factor, 0.15 * factor);
}

TEST(KeypointNoise, StaysWithinItsBounds) {
  const KeypointNoise start(1.5, {.least_px = 0.8, .largest_px = 3.0});
  EXPECT_DOUBLE_EQ(start.px(), 1.5);
  EXPECT_DOUBLE_EQ(AfterFrames(start, 0.01, 0.0), 0.8);
  EXPECT_DOUBLE_EQ(AfterFrames(start, 1.0, 1.0), 3.0);
  EXPECT_DOUBLE_EQ(AfterFrames(KeypointNoise(2.0, {.least_px = 2.0, .largest_px = 2.0}), 9.0, 0.0),
                   2.0);
}

TEST(KeypointNoise, OneFrameWithoutSenseIsSoonForgotten) {
  KeypointNoise noise(1.5, {.least_px = 0.1, .largest_px = 100.0, .margin = 1.0});
  noise.Learn(INFINITY);
  EXPECT_LT(noise.px(), 2.0);
  EXPECT_NEAR(AfterFrames(noise, 1.0, 0.0), 1.0, 0.15);
}

TEST(KeypointNoiseOptions, AreChecked) {
  EXPECT_THROW((KeypointNoiseOptions{.least_px = 0.0}.Validate()), Error);
  EXPECT_THROW((KeypointNoiseOptions{.least_px = 2.0, .largest_px = 1.0}.Validate()), Error);
  EXPECT_THROW((KeypointNoiseOptions{.margin = 0.9}.Validate()), Error);
  EXPECT_THROW((KeypointNoiseOptions{.share = 1.5}.Validate()), Error);
  EXPECT_NO_THROW(KeypointNoiseOptions{}.Validate());
}

}  // namespace
}  // namespace gluevo::vo
