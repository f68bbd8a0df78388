#include "pose_manifold.h"

#include <algorithm>

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

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const PoseParameters result =
      ToParameters(vo::Plus(ToRigid3(x), Eigen::Map<const PoseTangent>(delta)));
  std::copy(result.begin(), result.end(), x_plus_delta);
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kAmbientSize, kPoseTangentSize, Eigen::RowMajor>> j(jacobian);
  j.setZero();
  j.topLeftCorner<3, 3>().setIdentity();
  j.bottomRightCorner<4, 3>() = QuaternionPlusJacobian(x + 3);
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<PoseTangent> difference(y_minus_x);
  difference = vo::Minus(ToRigid3(y), ToRigid3(x));
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kPoseTangentSize, kAmbientSize, Eigen::RowMajor>> j(jacobian);
  j.setZero();
  j.topLeftCorner<3, 3>().setIdentity();
  j.bottomRightCorner<3, 4>() = 4.0 * QuaternionPlusJacobian(x + 3).transpose();
  return true;
}

}  // namespace gluevo::vo
