#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "gluevo/vo/core/frame_result.h"

namespace gluevo::apps {

/// What stands under "stereo_calibration" in metrics.json: what the newest frame says; null where
/// it was not refined.
nlohmann::ordered_json StereoCalibrationJson(const std::vector<vo::FrameResult>& frames);

/// How far the calibration is off, for people; empty where it is right within a tenth of a pixel,
/// or within three standard deviations.
std::string TextOfStereoCalibration(const std::vector<vo::FrameResult>& frames);

}  // namespace gluevo::apps
