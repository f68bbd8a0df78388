#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gluevo::vo {

/// Whether a (homogeneous) point of a camera's frame can be projected onto z = 1. The bound is
/// relative: a ray at more than 89.9 degrees from the optical axis is behind.
inline bool IsInFront(const Eigen::Vector3d& point_in_cam) {
  return point_in_cam.z() > 1.7e-3 * point_in_cam.norm();
}

/// d(x / z, y / z) / d(x, y, z).
inline Eigen::Matrix<double, 2, 3> ProjectionJacobian(const Eigen::Vector3d& point_in_cam) {
  const double inverse_z = 1.0 / point_in_cam.z();
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian << inverse_z, 0.0, -point_in_cam.x() * inverse_z * inverse_z,  //
      0.0, inverse_z, -point_in_cam.y() * inverse_z * inverse_z;
  return jacobian;
}

}  // namespace gluevo::vo
