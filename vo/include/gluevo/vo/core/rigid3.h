#pragma once

#include <Eigen/Geometry>

namespace gluevo::vo {

/// A rigid transform. `b_from_a` takes coordinates in frame a to coordinates in frame b, so that
/// chains read left to right: c_from_a = c_from_b * b_from_a.
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  // metres

  Rigid3 Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {inverse, -(inverse * translation)};
  }
  Eigen::Matrix<double, 3, 4> Matrix() const {
    Eigen::Matrix<double, 3, 4> matrix;
    matrix << rotation.toRotationMatrix(), translation;
    return matrix;
  }

  friend Rigid3 operator*(const Rigid3& c_from_b, const Rigid3& b_from_a) {
    return {(c_from_b.rotation * b_from_a.rotation).normalized(),
            c_from_b.rotation * b_from_a.translation + c_from_b.translation};
  }
  friend Eigen::Vector3d operator*(const Rigid3& b_from_a, const Eigen::Vector3d& point_in_a) {
    return b_from_a.rotation * point_in_a + b_from_a.translation;
  }
};

}  // namespace gluevo::vo
