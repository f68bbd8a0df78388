#pragma once

#include <ceres/manifold.h>

#include <Eigen/Core>
#include <array>

#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo {

/// A pose as the solver sees it: position (metres), then the quaternion x, y, z, w.
using PoseParameters = std::array<double, 7>;

PoseParameters ToParameters(const Rigid3& pose);
Rigid3 ToRigid3(const double* parameters);

/// [v]_x, the matrix with [v]_x w = v x w.
Eigen::Matrix3d Skew(const Eigen::Vector3d& v);

/// The unit quaternion of a rotation vector (radians).
Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& rotation_vector);
/// Its inverse, of length at most pi.
Eigen::Vector3d LogSo3(const Eigen::Quaterniond& rotation);

/// Poses [p, q] with tangent [dp, dtheta]: p <- p + dp (world frame, metres), q <- q * exp(dtheta)
/// (body frame, radians).
class PoseManifold final : public ceres::Manifold {
 public:
  static constexpr int kAmbientSize = 7;
  static constexpr int kTangentSize = 6;
  using Tangent = Eigen::Matrix<double, kTangentSize, 1>;

  int AmbientSize() const override { return kAmbientSize; }
  int TangentSize() const override { return kTangentSize; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

  /// The same steps on a Rigid3.
  static Rigid3 Plus(const Rigid3& pose, const Tangent& delta);
  static Tangent Minus(const Rigid3& y, const Rigid3& x);
};

}  // namespace gluevo::vo
