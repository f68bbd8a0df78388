#pragma once

#include <Eigen/Core>

#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo {

/// [v]_x, the matrix with [v]_x w = v x w.
Eigen::Matrix3d Skew(const Eigen::Vector3d& v);

/// The unit quaternion of a rotation vector (radians).
Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& rotation_vector);
/// Its inverse, of length at most pi.
Eigen::Vector3d LogSo3(const Eigen::Quaterniond& rotation);

/// d Log(exp(v) exp(d)) / d d at d = 0: the inverse of the right Jacobian of SO(3) (Forster et al.
/// 2017, eq. 8 and following).
Eigen::Matrix3d InverseRightJacobian(const Eigen::Vector3d& rotation_vector);
/// d Log(exp(-v) exp(v + d)) / d d at d = 0, the right Jacobian itself (eq. 8).
Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& rotation_vector);

/// A small motion of a pose: dp (world frame, metres), then dtheta (body frame, radians).
inline constexpr int kPoseTangentSize = 6;
using PoseTangent = Eigen::Matrix<double, kPoseTangentSize, 1>;

/// p + dp, q * exp(dtheta).
Rigid3 Plus(const Rigid3& pose, const PoseTangent& delta);
/// The motion that takes x to y: Plus(x, Minus(y, x)) is y.
PoseTangent Minus(const Rigid3& y, const Rigid3& x);

}  // namespace gluevo::vo
