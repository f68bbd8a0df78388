#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/mapping/loop_keyframe.h"
#include "gluevo/vo/mapping/loop_verification.h"

namespace gluevo::vo::internal {

/// A point as two stereo pairs, a and b, see it.
struct TwoViewPoint {
  StereoKeypoint in_a;
  StereoKeypoint in_b;
};

/// The place on a camera's normalised plane of a point whose place and inverse depth (1/m) in a's
/// left camera is `point`, and its derivatives: by the point, and by the tangent (Plus) of
/// a_from_b, the bodies' motion, which is that of the camera's body. Nothing where the point is
/// not before the camera.
struct TwoViewProjection {
  Eigen::Vector2d place;
  Eigen::Matrix<double, 2, 3> by_point;
  Eigen::Matrix<double, 2, 6> by_motion;
};
std::optional<TwoViewProjection> ProjectInto(const Rigid3& body_from_cam, const Rigid3& a_from_b,
                                             const Rigid3& body_from_left,
                                             const Eigen::Vector3d& point);

/// The motion that fits what all four cameras see, its points estimated with it (bundle adjustment
/// of two stereo pairs), from a start near it. Points that no right camera sees take no part.
/// Observations, some of which may be wrong (Huber's loss), are taken to be as good as they fit,
/// from `noise_px` (of kReferenceFocalPx) on; the covariance is what they say then. Nothing where
/// they do not settle it.
std::optional<LoopMeasurement> RefineMotion(const StereoRig& rig,
                                            const std::vector<TwoViewPoint>& points,
                                            const Rigid3& a_from_b, double noise_px);

}  // namespace gluevo::vo::internal
