#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "gluevo/vo/geometry/pnp.h"

// How well a pose of the rig explains what it sees of points whose depth is uncertain.
namespace gluevo::vo {

/// One camera of the rig at a hypothetical pose.
struct PosedCamera {
  Eigen::Matrix3d cam_from_world_rotation;
  Eigen::Vector3d center_in_world;

  PosedCamera(const Rigid3& world_from_body, const Rigid3& body_from_cam) {
    const Rigid3 world_from_cam = world_from_body * body_from_cam;
    cam_from_world_rotation = world_from_cam.rotation.toRotationMatrix().transpose();
    center_in_world = world_from_cam.translation;
  }
};

struct PosedRig {
  PosedCamera left, right;
  PosedRig(const StereoRig& rig, const Rigid3& world_from_body)
      : left(world_from_body, rig.body_from_cam[0]), right(world_from_body, rig.body_from_cam[1]) {}
};

/// Residual of one view, and how far one standard deviation of the point's inverse depth moves it;
/// both in standard deviations of the keypoint.
struct ViewResidual {
  Eigen::Vector2d error;
  Eigen::Vector2d by_depth;
};

/// False where the point is not in front of the camera.
bool Residual(const PosedCamera& camera, const AnchoredPoint& point,
              const Eigen::Vector2d& observed, double weight, ViewResidual& result);

/// Squared Mahalanobis distance of stacked residuals r whose covariance is I + u u^T: the depth is
/// integrated out (matrix inversion lemma).
inline double Mahalanobis(double r_r, double r_u, double u_u) {
  return r_r - r_u * r_u / (1.0 + u_u);
}

/// A pose and what it makes of each observation.
struct Hypothesis {
  Rigid3 world_from_body;
  std::vector<PnpVerdict> verdicts;
  int inliers = 0;
  double votes = 0.0;  // Of the inliers.
  double score = 0.0;
};

Hypothesis Score(const StereoRig& rig, const Rigid3& world_from_body,
                 std::span<const PnpObservation> observations, double weight);

}  // namespace gluevo::vo
