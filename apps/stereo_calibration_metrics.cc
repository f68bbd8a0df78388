#include "stereo_calibration_metrics.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "newest_estimate.h"

namespace gluevo::apps {
namespace {

using Json = nlohmann::ordered_json;
using Estimate = vo::StereoCalibrationEstimate;

Json Milli(const Eigen::Vector3d& radians) {
  return {1e3 * radians.x(), 1e3 * radians.y(), 1e3 * radians.z()};
}

}  // namespace

Json StereoCalibrationJson(const std::vector<vo::FrameResult>& frames) {
  const Estimate* const estimate = NewestEstimate(frames, &vo::FrameResult::stereo_calibration);
  if (estimate == nullptr) {
    return nullptr;
  }
  return {{"turn_mrad", Milli(estimate->turn)},
          {"turn_sigma_mrad", Milli(estimate->turn_sigma)},
          {"right_image_off_px",
           {estimate->focal_px * estimate->turn.y(), -estimate->focal_px * estimate->turn.x()}},
          {"right_image_off_sigma_px",
           {estimate->focal_px * estimate->turn_sigma.y(),
            estimate->focal_px * estimate->turn_sigma.x()}},
          {"made_up_for", estimate->is_applied},
          {"moved", estimate->is_turned ? "camera" : "image"}};
}

std::string TextOfStereoCalibration(const std::vector<vo::FrameResult>& frames) {
  constexpr double kLeastPx = 0.1;
  constexpr double kSigmas = 3.0;
  const Estimate* const estimate = NewestEstimate(frames, &vo::FrameResult::stereo_calibration);
  if (estimate == nullptr || !estimate->is_applied) {
    return "";
  }
  const auto is_off = [&](int axis) {
    return std::abs(estimate->turn[axis]) >
           std::max(kLeastPx / estimate->focal_px, kSigmas * estimate->turn_sigma[axis]);
  };
  if (!is_off(0) && !is_off(1)) {
    return "";
  }
  std::ostringstream text;
  const double right_px = estimate->focal_px * estimate->turn.y();
  const double below_px = -estimate->focal_px * estimate->turn.x();
  text << std::fixed << std::setprecision(2)
       << "The stereo calibration is off, which is made up for: by what the frames show the right "
       << "image lies " << std::abs(right_px) << " px to the " << (right_px < 0.0 ? "left" : "right")
       << " of and " << std::abs(below_px) << " px " << (below_px < 0.0 ? "above" : "below")
       << " where it should";
  return text.str();
}

}  // namespace gluevo::apps
