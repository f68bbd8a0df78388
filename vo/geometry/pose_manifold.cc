#include "gluevo/vo/geometry/pose_manifold.h"

#include <cmath>

namespace gluevo::vo {
namespace {

// d(q * exp(dtheta)) / d(dtheta) at 0, rows x y z w; its columns are orthogonal, of length 1/2.
Eigen::Matrix<double, 4, 3> QuaternionPlusJacobian(const double* q) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  Eigen::Matrix<double, 4, 3> jacobian;
  jacobian << w, -z, y,  //
      z, w, -x,          //
      -y, x, w,          //
      -x, -y, -z;
  return 0.5 * jacobian;
}

}  // namespace

PoseParameters ToParameters(const Rigid3& pose) {
  const Eigen::Vector3d& p = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
}

Rigid3 ToRigid3(const double* parameters) {
  return {
      Eigen::Quaterniond(parameters[6], parameters[3], parameters[4], parameters[5]).normalized(),
      Eigen::Vector3d(parameters[0], parameters[1], parameters[2])};
}

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

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const PoseParameters result = ToParameters(Plus(ToRigid3(x), Eigen::Map<const Tangent>(delta)));
  std::copy(result.begin(), result.end(), x_plus_delta);
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kAmbientSize, kTangentSize, Eigen::RowMajor>> j(jacobian);
  j.setZero();
  j.topLeftCorner<3, 3>().setIdentity();
  j.bottomRightCorner<4, 3>() = QuaternionPlusJacobian(x + 3);
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Tangent> difference(y_minus_x);
  difference = Minus(ToRigid3(y), ToRigid3(x));
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kTangentSize, kAmbientSize, Eigen::RowMajor>> j(jacobian);
  j.setZero();
  j.topLeftCorner<3, 3>().setIdentity();
  j.bottomRightCorner<3, 4>() = 4.0 * QuaternionPlusJacobian(x + 3).transpose();
  return true;
}

Rigid3 PoseManifold::Plus(const Rigid3& pose, const Tangent& delta) {
  return {(pose.rotation * ExpSo3(delta.tail<3>())).normalized(),
          pose.translation + delta.head<3>()};
}

PoseManifold::Tangent PoseManifold::Minus(const Rigid3& y, const Rigid3& x) {
  Tangent difference;
  difference << y.translation - x.translation, LogSo3(x.rotation.conjugate() * y.rotation);
  return difference;
}

}  // namespace gluevo::vo
