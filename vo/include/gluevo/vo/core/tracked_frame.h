#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace gluevo::vo {

/// A point of the scene as one stereo frame sees it.
struct Observation {
  int64_t track_id = 0;  ///< The same in all frames that see the same point; never used again.
  Eigen::Vector2d left_pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d left = Eigen::Vector2d::Zero();  ///< Undistorted, on the normalised plane z = 1.
  bool has_right = false;
  Eigen::Vector2d right_pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();  ///< The same in the right camera.
  float tracking_confidence = 0.0F;                 ///< 0 to 1; 0 for a new track.
  float stereo_confidence = 0.0F;                   ///< 0 to 1; 0 without a right observation.
};

/// What a front end makes of one stereo frame. At most one observation a track.
struct TrackedFrame {
  int64_t timestamp_ns = 0;
  std::vector<Observation> observations;
  std::map<std::string, double> stages_ms;  ///< Time spent by stage ("match_stereo", ...).
  /// Where networks give tracks, of a frame with which some came in: how many frames before this
  /// one their image is; 0 for its own, which was waited for.
  std::optional<int> networks_age = {};
};

}  // namespace gluevo::vo
