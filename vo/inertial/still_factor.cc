#include "gluevo/vo/inertial/still_factor.h"

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {

using inertial_block::kPosition;
using inertial_block::kRotation;
using inertial_block::kVelocity;

StillResidual ComputeStillResidual(const StillFactor& factor, const InertialState& first,
                                   const InertialState& second) {
  const Rigid3& pose0 = first.world_from_body;
  const Rigid3& pose1 = second.world_from_body;
  const Eigen::Vector3d turned = LogSo3(pose0.rotation.conjugate() * pose1.rotation);
  const Eigen::Matrix3d log_by_turn = InverseRightJacobian(turned);
  const double of_position = factor.weight / factor.position_sigma_m;
  const double of_rotation = factor.weight / factor.rotation_sigma_rad;
  const double of_velocity = factor.weight / factor.velocity_sigma;
  StillResidual residual;
  residual.value << of_position * (pose1.translation - pose0.translation), of_rotation * turned,
      of_velocity * second.velocity_in_world;
  residual.by_first.setZero();
  residual.by_first.block<3, 3>(kPosition, kPosition).diagonal().setConstant(-of_position);
  residual.by_first.block<3, 3>(kRotation, kRotation) =
      -of_rotation * log_by_turn * (pose1.rotation.conjugate() * pose0.rotation).toRotationMatrix();
  residual.by_second.setZero();
  residual.by_second.block<3, 3>(kPosition, kPosition).diagonal().setConstant(of_position);
  residual.by_second.block<3, 3>(kRotation, kRotation) = of_rotation * log_by_turn;
  residual.by_second.block<3, 3>(kVelocity, kVelocity).diagonal().setConstant(of_velocity);
  return residual;
}

InertialNormalEquations NormalEquationsOf(const StillResidual& residual) {
  Eigen::Matrix<double, kStillRows, kInertialColumns> jacobian;
  jacobian << residual.by_first, residual.by_second, Eigen::Matrix<double, kStillRows, 2>::Zero();
  return {jacobian.transpose() * jacobian, jacobian.transpose() * residual.value};
}

StillFactor Join(const StillFactor& first, const StillFactor& second) {
  return {first.position_sigma_m + second.position_sigma_m,
          first.rotation_sigma_rad + second.rotation_sigma_rad, second.velocity_sigma,
          second.weight};
}

}  // namespace gluevo::vo
