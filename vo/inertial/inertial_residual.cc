#include "gluevo/vo/inertial/inertial_residual.h"

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {

using inertial_block::kAccelerometerBias;
using inertial_block::kGyroscopeBias;
using inertial_block::kPosition;
using inertial_block::kRotation;
using inertial_block::kVelocity;

InertialState StateOf(const Rigid3& world_from_body, const VelocityAndBias& motion) {
  return {world_from_body, motion.velocity_in_world, motion.bias};
}

InertialState Plus(const InertialState& state, const InertialVector& delta) {
  return {Plus(state.world_from_body, PoseTangent(delta.head<kPoseTangentSize>())),
          state.velocity_in_world + delta.segment<3>(kVelocity),
          {state.bias.gyroscope + delta.segment<3>(kGyroscopeBias),
           state.bias.accelerometer + delta.segment<3>(kAccelerometerBias)}};
}

InertialResidual ComputeInertialResidual(const InertialState& first, const InertialState& second,
                                         const Preintegration& measured,
                                         const Eigen::Vector3d& gravity_in_world, double shift_s) {
  const double dt = measured.duration_s;
  const Eigen::Quaterniond& rotation0 = first.world_from_body.rotation;
  const Eigen::Quaterniond& rotation1 = second.world_from_body.rotation;
  const Eigen::Matrix3d body_from_world = rotation0.conjugate().toRotationMatrix();
  const InertialMotion motion = measured.At(first.bias, shift_s);
  const Eigen::Vector3d moved =
      body_from_world * (second.world_from_body.translation - first.world_from_body.translation -
                         first.velocity_in_world * dt - 0.5 * dt * dt * gravity_in_world);
  const Eigen::Vector3d gained =
      body_from_world *
      (second.velocity_in_world - first.velocity_in_world - dt * gravity_in_world);
  const Eigen::Vector3d turned =
      LogSo3(motion.rotation.conjugate() * rotation0.conjugate() * rotation1);

  InertialResidual residual;
  residual.value << moved - motion.position, turned, gained - motion.velocity,
      second.bias.gyroscope - first.bias.gyroscope,
      second.bias.accelerometer - first.bias.accelerometer;

  const Eigen::Matrix3d log_by_turn = InverseRightJacobian(turned);
  const Eigen::Vector3d correction =
      measured.by_bias.block<3, 3>(kRotation, 0) * (first.bias.gyroscope - measured.bias.gyroscope);
  InertialMatrix& by_first = residual.by_first;
  by_first.setZero();
  by_first.block<3, 3>(kPosition, kPosition) = -body_from_world;
  by_first.block<3, 3>(kPosition, kRotation) = Skew(moved);
  by_first.block<3, 3>(kPosition, kVelocity) = -dt * body_from_world;
  by_first.block<3, 3>(kRotation, kRotation) =
      -log_by_turn * (rotation1.conjugate() * rotation0).toRotationMatrix();
  by_first.block<3, 3>(kVelocity, kRotation) = Skew(gained);
  by_first.block<3, 3>(kVelocity, kVelocity) = -body_from_world;
  by_first.middleRows<3>(kPosition).rightCols<6>() = -measured.by_bias.middleRows<3>(kPosition);
  by_first.middleRows<3>(kVelocity).rightCols<6>() = -measured.by_bias.middleRows<3>(kVelocity);
  by_first.block<3, 3>(kRotation, kGyroscopeBias) =
      -log_by_turn * ExpSo3(turned).conjugate().toRotationMatrix() * RightJacobian(correction) *
      measured.by_bias.block<3, 3>(kRotation, 0);
  by_first.bottomRightCorner<6, 6>().diagonal().setConstant(-1.0);

  InertialMatrix& by_second = residual.by_second;
  by_second.setZero();
  by_second.block<3, 3>(kPosition, kPosition) = body_from_world;
  by_second.block<3, 3>(kRotation, kRotation) = log_by_turn;
  by_second.block<3, 3>(kVelocity, kVelocity) = body_from_world;
  by_second.bottomRightCorner<6, 6>().diagonal().setConstant(1.0);

  residual.by_gravity.setZero();
  residual.by_gravity.middleRows<3>(kPosition) = -0.5 * dt * dt * body_from_world;
  residual.by_gravity.middleRows<3>(kVelocity) = -dt * body_from_world;

  const Eigen::Vector3d turn = measured.by_time_offset.segment<3>(kRotation);
  residual.by_shift << -measured.by_time_offset.segment<3>(kPosition),
      -log_by_turn * (ExpSo3(correction) * ExpSo3(turned)).conjugate().toRotationMatrix() *
          RightJacobian(shift_s * turn) * turn,
      -measured.by_time_offset.segment<3>(kVelocity), Eigen::Matrix<double, 6, 1>::Zero();
  return residual;
}

InertialState Predict(const InertialState& first, const Preintegration& measured,
                      const Eigen::Vector3d& gravity_in_world) {
  const double dt = measured.duration_s;
  const Rigid3& start = first.world_from_body;
  const InertialMotion motion = measured.At(first.bias);
  return {{(start.rotation * motion.rotation).normalized(),
           start.translation + first.velocity_in_world * dt + 0.5 * dt * dt * gravity_in_world +
               start.rotation * motion.position},
          first.velocity_in_world + dt * gravity_in_world + start.rotation * motion.velocity,
          first.bias};
}

}  // namespace gluevo::vo
