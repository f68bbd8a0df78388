#include "gluevo/vo/geometry/manifold.h"

#include <cmath>

namespace gluevo::vo {

Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(),  //
      v.z(), 0.0, -v.x(),        //
      -v.y(), v.x(), 0.0;
  return matrix;
}

Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& rotation_vector) {
  const double half_angle = 0.5 * rotation_vector.norm();
  // sin(x) / x, by its series where the quotient would lose digits.
  const double sinc =
      half_angle < 1e-4 ? 1.0 - half_angle * half_angle / 6.0 : std::sin(half_angle) / half_angle;
  const Eigen::Vector3d xyz = 0.5 * sinc * rotation_vector;
  return Eigen::Quaterniond(std::cos(half_angle), xyz.x(), xyz.y(), xyz.z()).normalized();
}

Eigen::Vector3d LogSo3(const Eigen::Quaterniond& rotation) {
  // q and -q are the same rotation; the one with w >= 0 has the angle below pi.
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d xyz = sign * rotation.vec();
  const double sine = xyz.norm();
  const double cosine = sign * rotation.w();
  if (sine < 1e-8) {
    return 2.0 / cosine * xyz;
  }
  return 2.0 * std::atan2(sine, cosine) / sine * xyz;
}

Eigen::Matrix3d InverseRightJacobian(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  const Eigen::Matrix3d cross = Skew(rotation_vector);
  // (1 - (a / 2) cot(a / 2)) / a^2, by its series near 0.
  const double quadratic = angle < 1e-3
                               ? 1.0 / 12.0 + angle * angle / 720.0
                               : (1.0 - 0.5 * angle / std::tan(0.5 * angle)) / (angle * angle);
  return Eigen::Matrix3d::Identity() + 0.5 * cross + quadratic * cross * cross;
}

Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  const double square = angle * angle;
  const Eigen::Matrix3d cross = Skew(rotation_vector);
  // (1 - cos a) / a^2 and (a - sin a) / a^3, by their series near 0.
  const bool is_small = angle < 1e-3;
  const double linear = is_small ? 0.5 - square / 24.0 : (1.0 - std::cos(angle)) / square;
  const double quadratic =
      is_small ? 1.0 / 6.0 - square / 120.0 : (angle - std::sin(angle)) / (square * angle);
  return Eigen::Matrix3d::Identity() - linear * cross + quadratic * cross * cross;
}

Rigid3 Plus(const Rigid3& pose, const PoseTangent& delta) {
  return {(pose.rotation * ExpSo3(delta.tail<3>())).normalized(),
          pose.translation + delta.head<3>()};
}

PoseTangent Minus(const Rigid3& y, const Rigid3& x) {
  PoseTangent difference;
  difference << y.translation - x.translation, LogSo3(x.rotation.conjugate() * y.rotation);
  return difference;
}

}  // namespace gluevo::vo
