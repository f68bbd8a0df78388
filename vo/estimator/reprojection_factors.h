#pragma once

#include <ceres/sized_cost_function.h>

#include <Eigen/Core>

#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo {

/// A landmark: where its anchor, the left view of a frame, sees it on the normalised plane (u, v),
/// and its inverse depth lambda there (1/m; Civera et al. 2008). As parameters: u, v, lambda.
///
/// VINS-Fusion estimates lambda alone and takes the measured (u, v) for exact. But the noise of
/// that measurement is in every residual of the landmark, and a stereo rig's depths are as noisy as
/// its disparities: the motion comes out too small (regression on a noisy variable), by an amount
/// that grows with the square of the noise. With (u, v) estimated and the anchor's view a residual
/// like all others, the estimate is the maximum-likelihood one.

/// The stereo residuals of a landmark anchored in frame i (Qin et al. 2018, eq. 25, with stereo as
/// in VINS-Fusion). All points are on the normalised plane; `weight` is one over their standard
/// deviation there, so residuals have no unit. The point is carried homogeneously, as ray +
/// lambda * (...), so that lambda may come close to 0 (a point far away).
///
/// How the right camera sees may be refined: `turn` (3 values, radians) and `bend` are those of
/// RightImageOffset. The turn is zero for the left camera, whose frame is the rig's reference.
///
/// A point behind the camera that sees it gives a large constant residual with zero Jacobian: the
/// solver rejects steps that lead there, and a landmark that starts there is left alone.

/// Anchored in frame i, seen by a camera (left or right) of another frame j.
/// Parameters: world_from_body of i and of j (PoseParameters), landmark, the turn of the camera
/// that sees it.
class OtherFrameReprojection final : public ceres::SizedCostFunction<2, 7, 7, 3, 3> {
 public:
  /// `body_from_anchor_cam` is the left camera's; `body_from_cam` that of the camera that sees
  /// the point at `observed`.
  OtherFrameReprojection(const Rigid3& body_from_anchor_cam, const Rigid3& body_from_cam,
                         const Eigen::Vector2d& observed, double weight, double bend = 1.0);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Matrix3d body_from_anchor_rotation_;
  Eigen::Vector3d anchor_center_in_body_;  // metres
  Eigen::Matrix3d cam_from_body_rotation_;
  Eigen::Vector3d cam_from_body_translation_;
  Eigen::Vector2d observed_;
  double weight_;
  double bend_;
};

/// Anchored in a frame and seen by a camera of the same frame: the right one, or the left one
/// itself (the identity as transform). Parameters: landmark, the turn of
/// the camera that sees it.
class SameFrameReprojection final : public ceres::SizedCostFunction<2, 3, 3> {
 public:
  SameFrameReprojection(const Rigid3& cam_from_anchor_cam, const Eigen::Vector2d& observed,
                        double weight, double bend = 1.0);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Matrix3d cam_from_anchor_rotation_;
  Eigen::Vector3d anchor_center_in_cam_;  // metres
  Eigen::Vector2d observed_;
  double weight_;
  double bend_;
};

}  // namespace gluevo::vo
