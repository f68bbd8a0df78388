#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "gluevo/nn/features.h"
#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::vo {

/// Where a key frame's keypoint is, seen from its own two cameras. Both views on the normalised
/// planes.
struct StereoKeypoint {
  Eigen::Vector2d left = Eigen::Vector2d::Zero();  ///< NaN beyond the camera's model.
  bool has_right = false;
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  /// 1/m along the left camera's axis; 0 where the keypoint has no depth.
  double inverse_depth = 0.0;
};

/// What the network that loops use has found in a frame's images already; nothing where it has not
/// run.
using KnownFeatures = std::array<std::optional<nn::Features>, 2>;

/// Of a motion that is doubtful (FrameResult::is_doubtful): it may be any of about this length. The
/// turn tells such motions from others.
PoseCovariance DoubtfulMotion(const PoseCovariance& covariance, const Rigid3& motion);
/// Whether that was added to a motion's covariance.
bool IsDoubtful(const PoseCovariance& motion_covariance);

/// What is kept of a key frame to come back to it.
struct LoopKeyframe {
  int64_t timestamp_ns = 0;
  int segment = 0;         ///< As FrameResult::segment.
  Rigid3 world_from_body;  ///< As the odometry had it.
  /// Since the key frame before it in the same segment, the body's pose in that one's frame, as
  /// odometry had both when it was done with them: world_from_body is not revised.
  Rigid3 motion;
  PoseCovariance motion_covariance = PoseCovariance::Zero();  ///< Of the motion.
  nn::Features features;                                      ///< Of the left image.
  std::vector<StereoKeypoint> keypoints;                      ///< One a feature.
};

/// The keypoints of the left image with the depths that their places in the right image tell:
/// `right_pixels`, one each, NaN where there is none. Those farther than `max_epipolar_error_px`
/// from their epipolar lines, and points less than a pixel of kReferenceFocalPx nearer than
/// infinity, have no depth.
std::vector<StereoKeypoint> LocateKeypoints(const StereoRig& rig, const nn::Features& left,
                                            const std::vector<Eigen::Vector2d>& right_pixels,
                                            double max_epipolar_error_px);
/// The same by matches to the right image's keypoints.
std::vector<StereoKeypoint> LocateKeypoints(const StereoRig& rig, const nn::Features& left,
                                            const nn::Features& right, const nn::Matches& stereo,
                                            double max_epipolar_error_px);

}  // namespace gluevo::vo
