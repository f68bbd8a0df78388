#include "pose_graph_edge.h"

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo::internal {

EdgeError ErrorOfEdge(const Rigid3& a_from_b, const Rigid3& world_from_a,
                      const Rigid3& world_from_b, EdgeJacobian* by_a, EdgeJacobian* by_b) {
  const Eigen::Matrix3d measured_b_from_a = a_from_b.rotation.toRotationMatrix().transpose();
  const Rigid3 between = world_from_a.Inverse() * world_from_b;
  EdgeError error;
  error.head<3>() = measured_b_from_a * (between.translation - a_from_b.translation);
  error.tail<3>() = LogSo3(a_from_b.rotation.conjugate() * between.rotation);
  const Eigen::Matrix3d by_turn = InverseRightJacobian(error.tail<3>());
  const Eigen::Matrix3d by_position =
      measured_b_from_a * world_from_a.rotation.toRotationMatrix().transpose();
  if (by_a != nullptr) {
    *by_a << -by_position, measured_b_from_a * Skew(between.translation), Eigen::Matrix3d::Zero(),
        -by_turn * between.rotation.toRotationMatrix().transpose();
  }
  if (by_b != nullptr) {
    *by_b << by_position, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(), by_turn;
  }
  return error;
}

Eigen::Matrix<double, 4, 3> QuaternionByTurn(const Eigen::Quaterniond& q) {
  Eigen::Matrix<double, 4, 3> derivative;
  derivative << q.w() * Eigen::Matrix3d::Identity() + Skew(q.vec()), -q.vec().transpose();
  return 0.5 * derivative;
}

Eigen::Matrix<double, 3, 4> TurnByQuaternion(const Eigen::Quaterniond& q) {
  return 4.0 * QuaternionByTurn(q).transpose();  // Its columns are perpendicular, of length 1/2.
}

}  // namespace gluevo::vo::internal
