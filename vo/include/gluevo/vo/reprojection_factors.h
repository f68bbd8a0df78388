#pragma once

#include <ceres/sized_cost_function.h>

#include <Eigen/Core>

#include "gluevo/vo/rigid3.h"

namespace gluevo::vo {

/// The three stereo residuals of a landmark with inverse depth lambda along the ray of its anchor,
/// the left view of frame i (Qin et al. 2018, eq. 25, with stereo as in VINS-Fusion). All points
/// are on the normalised plane; `weight` is one over their standard deviation there, so residuals
/// have no unit. The point is carried homogeneously, as ray + lambda * (...), so that lambda may
/// come close to 0 (a point far away).
///
/// A camera's orientation in the rig may be refined: `turn` (3 values, radians) moves a point x of
/// its frame to x + turn x x. That is a rotation to first order, which is all there is to turns of
/// a milliradian. It is zero for the left camera, whose frame is the rig's reference.
///
/// A point behind the camera that sees it gives a large constant residual with zero Jacobian: the
/// solver rejects steps that lead there, and a landmark that starts there is left alone.

/// Anchor left in frame i, seen by a camera (left or right) of another frame j.
/// Parameters: world_from_body of i and of j (PoseParameters), lambda (1/m), the turn of the camera
/// that sees the point.
class OtherFrameReprojection final : public ceres::SizedCostFunction<2, 7, 7, 1, 3> {
 public:
  /// `body_from_anchor_cam` is the left camera's; `body_from_cam` that of the camera that sees
  /// the point at `observed`.
  OtherFrameReprojection(const Rigid3& body_from_anchor_cam, const Rigid3& body_from_cam,
                         const Eigen::Vector2d& anchor, const Eigen::Vector2d& observed,
                         double weight);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Matrix3d cam_from_body_rotation_;
  Eigen::Vector3d cam_from_body_translation_;
  Eigen::Vector3d ray_in_body_;            // the anchor's ray, z = 1 in the left camera
  Eigen::Vector3d anchor_center_in_body_;  // metres
  Eigen::Vector2d observed_;
  double weight_;
};

/// Anchor left in frame i, seen by the right camera of the same frame. Parameters: lambda (1/m),
/// the right camera's turn.
class SameFrameReprojection final : public ceres::SizedCostFunction<2, 1, 3> {
 public:
  SameFrameReprojection(const Rigid3& right_from_left, const Eigen::Vector2d& anchor,
                        const Eigen::Vector2d& observed, double weight);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector3d ray_in_right_;
  Eigen::Vector3d left_center_in_right_;  // metres
  Eigen::Vector2d observed_;
  double weight_;
};

}  // namespace gluevo::vo
