#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "gluevo/vo/core/inertial_estimate.h"
#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/right_camera_finding.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/core/tracked_frame.h"
#include "gluevo/vo/core/trajectory.h"

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
  /// The frame shows nothing by which it could be located: its pose is where the inertial unit
  /// leads, or without one guessed from the motion before, and the frames after it are matched with
  /// those before it.
  bool is_predicted = false;
  /// It shows something, but nothing that was seen before: its pose is where the inertial unit
  /// leads. The frames after it are matched with it.
  bool is_bridged = false;
  /// Whether less than half of what has a say (see VoteOptions) agrees with the pose: it may be
  /// that of something that moves through the scene.
  bool is_doubtful = false;
  /// Whether it was located with next to nothing in the right image: by the left one alone.
  bool is_left_only = false;
  /// The motion since the newest key frame before this one (of a predicted pose since the last one
  /// that was located), which was at `motion_from_ns`: the body's pose in that one's frame, as the
  /// window has both now. The key frame's pose may have been revised since it was given. At the
  /// first frame of a segment from itself.
  Rigid3 keyframe_from_body;
  int64_t motion_from_ns = 0;
  PoseCovariance motion_covariance = PoseCovariance::Zero();  ///< How good it is.
  /// How good world_from_body is, in the frame of the segment's first pose.
  PoseCovariance path_covariance = PoseCovariance::Zero();
  /// Once an inertial unit has started, of frames that were located.
  std::optional<InertialEstimate> inertial;
  /// Where it is refined, of frames that were located.
  std::optional<RightCameraFinding> right_camera;
  /// World_from_body of the newest frames as they are known now, the oldest first, this frame's the
  /// last: what was given for the others before may have been revised. Empty of a predicted pose.
  Trajectory window;
  int observations = 0;  ///< Tracks in the frame.
  int matched = 0;       ///< Of these, those found again from frames before.
  int tracked = 0;       ///< Of these, known points (with a depth).
  int stereo = 0;        ///< Of these, seen by both cameras.
  int inliers = 0;       ///< Known points that agree with the pose.
  int moving = 0;        ///< Tracks that are kept out since they move by themselves.
  /// Of a pose that was found but not taken since nothing moves so fast; 0 where there was none.
  double refused_speed_m_per_s = 0.0;
  /// A pose was found but not taken since the inertial unit contradicts it.
  bool is_refused_by_inertia = false;
  int landmarks = 0;                        ///< Landmarks with a depth in the window.
  TrackedFrame tracked_frame;               ///< What the pose was estimated from.
  std::map<std::string, double> stages_ms;  ///< The front end's, "frontend" and "estimator".
};

}  // namespace gluevo::vo
