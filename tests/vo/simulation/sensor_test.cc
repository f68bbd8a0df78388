#include "sensor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace gluevo::simulation {
namespace {

cv::Mat Gray(double value) { return {200, 300, CV_32FC1, cv::Scalar(value)}; }

ImageOptions Silent() {
  ImageOptions options;
  options.noise = 0.0;
  return options;
}

struct Statistics {
  double mean = 0.0;
  double deviation = 0.0;
};

Statistics Of(const cv::Mat& image) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(image, mean, deviation);
  return {mean[0], deviation[0]};
}

TEST(SensorTest, KeepsAnExactImage) {
  const cv::Mat image = Sensor(Silent()).Expose(Gray(99.6), 1.0, 1);
  EXPECT_EQ(Of(image).mean, 100.0);
  EXPECT_EQ(Of(image).deviation, 0.0);
  EXPECT_EQ(Of(Sensor(Silent()).Expose(Gray(99.6), 10.0, 1)).mean, 255.0);
}

TEST(SensorTest, NoiseGrowsWithTheBrightness) {
  const Sensor sensor((ImageOptions()));
  // Rounding adds 1 / 12 to the variance.
  EXPECT_NEAR(Of(sensor.Expose(Gray(127.5), 1.0, 1)).deviation, std::sqrt(2.0 + 1.0 / 12.0), 0.03);
  EXPECT_NEAR(Of(sensor.Expose(Gray(20.0), 1.0, 1)).deviation, std::sqrt(4.0 / 9.0 + 1.0 / 12.0),
              0.02);
  EXPECT_NE(cv::norm(sensor.Expose(Gray(90.0), 1.0, 1), sensor.Expose(Gray(90.0), 1.0, 2)), 0.0);
  EXPECT_EQ(cv::norm(sensor.Expose(Gray(90.0), 1.0, 1), sensor.Expose(Gray(90.0), 1.0, 1)), 0.0);
}

TEST(SensorTest, LowLightIsDarkerAndNoisier) {
  ImageOptions options;
  options.light = 0.25;
  // A quarter of the light, doubled again, with doubled noise of a quarter of the photons.
  const Statistics dusk = Of(Sensor(options).Expose(Gray(200.0), 1.0, 3));
  EXPECT_NEAR(dusk.mean, 100.0, 0.1);
  EXPECT_NEAR(dusk.deviation, std::sqrt(16.0 * 50.0 / 255.0 + 1.0 / 12.0), 0.04);
}

TEST(SensorTest, VignettingDarkensTheCorners) {
  ImageOptions options = Silent();
  options.vignetting = 0.4;
  const cv::Mat image = Sensor(options).Expose(Gray(200.0), 1.0, 1);
  for (const cv::Point corner : {cv::Point(0, 0), cv::Point(299, 0), cv::Point(299, 199)}) {
    EXPECT_EQ(image.at<uint8_t>(corner), 120);
  }
  EXPECT_EQ(image.at<uint8_t>(100, 150), 200);
}

TEST(SensorTest, ExposureWandersSmoothlyWithinItsStops) {
  ImageOptions options;
  options.exposure_change = 1.0;
  const Sensor sensor(options);
  double least = 2.0;
  double most = 0.5;
  for (double time = 0.0; time < 60.0; time += 0.1) {
    const double exposure = sensor.Exposure(time, 7);
    least = std::min(least, exposure);
    most = std::max(most, exposure);
    // At most 2 pi / 3 s stops a second.
    EXPECT_LT(std::abs(std::log2(sensor.Exposure(time + 0.1, 7) / exposure)), 0.21);
  }
  EXPECT_GE(least, 0.5);
  EXPECT_LE(most, 2.0);
  EXPECT_GT(most / least, 1.8);
  EXPECT_NE(sensor.Exposure(1.0, 7), sensor.Exposure(1.0, 8));
  EXPECT_EQ(Sensor(ImageOptions()).Exposure(1.0, 7), 1.0);
}

}  // namespace
}  // namespace gluevo::simulation
