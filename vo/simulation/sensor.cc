#include "sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gluevo::simulation {

namespace {

const NormalTable& SharedNormalTable() {
  static const NormalTable table;
  return table;
}

}  // namespace

Sensor::Sensor(const ImageOptions& options) : options_(options), normal_(SharedNormalTable()) {}

double Sensor::Exposure(double time_s, uint64_t seed) const {
  if (options_.exposure_change == 0.0) return 1.0;
  // Three waves of 3 to 12 s, whose amplitudes add up to the whole.
  RandomStream random(seed);
  double stops = 0.0;
  for (const double share : {0.5, 0.3, 0.2}) {
    const double period_s = random.Uniform(3.0, 12.0);
    const double phase = random.Uniform(0.0, 1.0);
    stops += share * std::sin(2.0 * std::numbers::pi * (time_s / period_s + phase));
  }
  return std::exp2(options_.exposure_change * stops);
}

cv::Mat Sensor::Expose(const cv::Mat& brightness, double exposure, uint64_t noise_seed) const {
  // Of less light the camera makes up half (in stops) by its gain, which also amplifies the noise.
  const double gain = 1.0 / std::sqrt(options_.light);
  const auto light = static_cast<float>(options_.light * exposure);
  const auto amplified = static_cast<float>(gain);
  const auto noise = static_cast<float>(options_.noise * gain);
  const double center_x = 0.5 * (brightness.cols - 1);
  const double center_y = 0.5 * (brightness.rows - 1);
  const auto falloff =
      static_cast<float>(options_.vignetting / (center_x * center_x + center_y * center_y));
  cv::Mat image(brightness.size(), CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    const float* const from = brightness.ptr<float>(y);
    uint8_t* const to = image.ptr<uint8_t>(y);
    const auto dy = static_cast<float>(y - center_y);
    for (int x = 0; x < image.cols; ++x) {
      const auto dx = static_cast<float>(x - center_x);
      const float photons = from[x] * light * (1.0F - falloff * (dx * dx + dy * dy));
      float value = photons * amplified;
      if (noise > 0.0F) {
        constexpr float kDarkVariance = 1.0F / 9.0F;
        value += noise * std::sqrt(std::max(photons / 255.0F, kDarkVariance)) *
                 normal_(Hash(noise_seed, static_cast<uint64_t>(y) * image.cols + x));
      }
      to[x] = static_cast<uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
    }
  }
  return image;
}

}  // namespace gluevo::simulation
