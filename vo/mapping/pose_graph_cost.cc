#include "pose_graph_cost.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <string>

#include "gluevo/nn/error.h"
#include "gluevo/vo/geometry/manifold.h"
#include "pose_graph_edge.h"

namespace gluevo::vo::internal {

Rigid3 PoseOf(const double* parameters) {
  return {Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(parameters + 3)).normalized(),
          Eigen::Map<const Eigen::Vector3d>(parameters)};
}

PoseParameters ParametersOf(const Rigid3& pose) {
  PoseParameters parameters{};
  Eigen::Map<Eigen::Vector3d>(parameters.data()) = pose.translation;
  Eigen::Map<Eigen::Vector4d>(parameters.data() + 3) = pose.rotation.coeffs();
  return parameters;
}

Eigen::Matrix<double, 6, 6> Whitening(const PoseGraphEdge& edge) {
  const Eigen::LLT<PoseCovariance> cholesky(edge.covariance);
  if (cholesky.info() != Eigen::Success) {
    throw Error("the covariance of the edge between poses " + std::to_string(edge.a) + " and " +
                std::to_string(edge.b) + " of a graph is not positive definite");
  }
  Eigen::Matrix<double, 6, 6> whitening = Eigen::Matrix<double, 6, 6>::Identity();
  cholesky.matrixL().solveInPlace(whitening);
  return whitening;
}

bool EdgeCost::Evaluate(double const* const* poses, double* residuals, double** jacobians) const {
  const std::array<Rigid3, 2> world_from = {PoseOf(poses[0]), PoseOf(poses[1])};
  std::array<EdgeJacobian, 2> by;
  Eigen::Map<EdgeError>{residuals} =
      whitening_ * ErrorOfEdge(a_from_b_, world_from[0], world_from[1], &by[0], &by[1]);
  for (std::size_t i = 0; jacobians != nullptr && i < by.size(); ++i) {
    if (jacobians[i] == nullptr) {
      continue;
    }
    Eigen::Map<Eigen::Matrix<double, 6, kPoseSize, Eigen::RowMajor>> jacobian(jacobians[i]);
    const EdgeJacobian whitened = whitening_ * by[i];
    jacobian.leftCols<3>() = whitened.leftCols<3>();
    jacobian.rightCols<4>() = whitened.rightCols<3>() * TurnByQuaternion(world_from[i].rotation);
  }
  return true;
}

PoseManifold::Turns PoseManifold::TurnsOf(const Eigen::Quaterniond& rotation) const {
  return axis_in_world_ ? Turns(rotation.conjugate() * *axis_in_world_)
                        : Turns(Eigen::Matrix3d::Identity());
}

bool PoseManifold::Plus(const double* x, const double* delta, double* sum) const {
  const Rigid3 pose = PoseOf(x);
  const Eigen::Map<const Eigen::VectorXd> turn(delta + 3, TangentSize() - 3);
  PoseTangent tangent;
  tangent << Eigen::Map<const Eigen::Vector3d>(delta), TurnsOf(pose.rotation) * turn;
  const PoseParameters moved = ParametersOf(vo::Plus(pose, tangent));
  std::copy(moved.begin(), moved.end(), sum);
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Jacobian> derivative(jacobian, kPoseSize, TangentSize());
  const Eigen::Quaterniond rotation = PoseOf(x).rotation;
  derivative.setZero();
  derivative.topLeftCorner<3, 3>().setIdentity();
  derivative.bottomRightCorner(4, TangentSize() - 3) =
      QuaternionByTurn(rotation) * TurnsOf(rotation);
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* difference) const {
  const Rigid3 pose = PoseOf(x);
  const PoseTangent tangent = vo::Minus(PoseOf(y), pose);
  Eigen::Map<Eigen::VectorXd>(difference, TangentSize()) << tangent.head<3>(),
      TurnsOf(pose.rotation).transpose() * tangent.tail<3>();
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Jacobian> derivative(jacobian, TangentSize(), kPoseSize);
  const Eigen::Quaterniond rotation = PoseOf(x).rotation;
  derivative.setZero();
  derivative.topLeftCorner<3, 3>().setIdentity();
  derivative.bottomRightCorner(TangentSize() - 3, 4) =
      TurnsOf(rotation).transpose() * TurnByQuaternion(rotation);
  return true;
}

}  // namespace gluevo::vo::internal
