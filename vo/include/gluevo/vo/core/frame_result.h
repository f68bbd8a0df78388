#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/core/tracked_frame.h"

namespace gluevo::vo {

/// What became of one frame.
struct FrameResult {
  int64_t timestamp_ns = 0;
  /// World frame: the body's at the first frame.
  Rigid3 world_from_body;
  bool is_keyframe = false;
  /// Starts at 0 and grows by one where the pose could not be linked to those before: poses of
  /// different segments have nothing to do with each other.
  int segment = 0;
  int observations = 0;                     ///< Tracks in the frame.
  int tracked = 0;                          ///< Of these, known points (with a depth) from before.
  int stereo = 0;                           ///< Of these, seen by both cameras.
  int inliers = 0;                          ///< Known points that agree with the pose.
  int landmarks = 0;                        ///< Landmarks with a depth in the window.
  TrackedFrame tracked_frame;               ///< What the pose was estimated from.
  std::map<std::string, double> stages_ms;  ///< The front end's, "frontend" and "estimator".
};

}  // namespace gluevo::vo
