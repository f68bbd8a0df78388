#include "gluevo/vo/pipeline/keypoint_noise.h"

#include <algorithm>
#include <cmath>

#include "gluevo/vo/core/options_check.h"

namespace gluevo::vo {

void KeypointNoiseOptions::Validate() const {
  CheckPositive(least_px, "keypoint_noise.least_px");
  CheckWithin(largest_px, least_px, 1e3, "keypoint_noise.largest_px");
  CheckWithin(margin, 1.0, 10.0, "keypoint_noise.margin");
  CheckWithin(share, 0.0, 1.0, "keypoint_noise.share");
}

KeypointNoise::KeypointNoise(double start_px, const KeypointNoiseOptions& options)
    : options_(options), px_(std::max(options.least_px, std::min(options.largest_px, start_px))) {}

void KeypointNoise::Learn(double median_error_px) {
  // Of the length of a vector whose two parts have a standard deviation of one (Rayleigh).
  const double expected = std::sqrt(2.0 * std::log(2.0)) / options_.margin;
  // One frame without any sense is not to be felt for long.
  constexpr double kMostFactor = 2.0;
  const double factor =
      std::clamp(median_error_px / (expected * px_), 1.0 / kMostFactor, kMostFactor);
  px_ = std::clamp(px_ * std::pow(factor, options_.share), options_.least_px, options_.largest_px);
}

}  // namespace gluevo::vo
