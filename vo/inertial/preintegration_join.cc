#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/inertial/preintegration.h"

namespace gluevo::vo {

using inertial_block::kPosition;
using inertial_block::kRotation;
using inertial_block::kVelocity;

Preintegration AcrossGap(double duration_s, const ImuBias& bias, const ImuNoise& noise) {
  constexpr double kUnknown = 1e4;
  constexpr double kUnknownTurn = 10.0;
  const double gyroscope = noise.gyroscope_random_walk * noise.gyroscope_random_walk * duration_s;
  const double accelerometer =
      noise.accelerometer_random_walk * noise.accelerometer_random_walk * duration_s;
  Preintegration gap;
  gap.duration_s = duration_s;
  gap.bias = bias;
  gap.covariance.diagonal() << Eigen::Vector3d::Constant(kUnknown * kUnknown),
      Eigen::Vector3d::Constant(kUnknownTurn * kUnknownTurn),
      Eigen::Vector3d::Constant(kUnknown * kUnknown), Eigen::Vector3d::Constant(gyroscope),
      Eigen::Vector3d::Constant(accelerometer);
  return gap;
}

Preintegration Join(const Preintegration& first, const Preintegration& second) {
  const InertialMotion& motion = first.motion;
  const InertialMotion rest = second.At(first.bias, first.time_offset_s - second.time_offset_s);
  const double dt = second.duration_s;
  const Eigen::Matrix3d rotation = motion.rotation.toRotationMatrix();

  Preintegration joined;
  joined.duration_s = first.duration_s + dt;
  joined.bias = first.bias;
  joined.motion = {(motion.rotation * rest.rotation).normalized(),
                   motion.velocity + rotation * rest.velocity,
                   motion.position + motion.velocity * dt + rotation * rest.position};

  // How errors at the second's end follow from those at its begin, and from its own.
  InertialMatrix own = InertialMatrix::Identity();
  own.block<3, 3>(kPosition, kPosition) = rotation;
  own.block<3, 3>(kVelocity, kVelocity) = rotation;
  InertialMatrix transition = InertialMatrix::Identity();
  transition.block<3, 3>(kPosition, kRotation) = -rotation * Skew(rest.position);
  transition.block<3, 3>(kPosition, kVelocity) = dt * Eigen::Matrix3d::Identity();
  transition.block<3, 3>(kRotation, kRotation) = rest.rotation.conjugate().toRotationMatrix();
  transition.block<3, 3>(kVelocity, kRotation) = -rotation * Skew(rest.velocity);
  transition.topRightCorner<9, 6>() = own.topLeftCorner<9, 9>() * second.by_bias;

  Eigen::Matrix<double, kInertialTangentSize, 6> by_bias;
  by_bias << first.by_bias, Eigen::Matrix<double, 6, 6>::Identity();
  joined.by_bias = transition.topRows<9>() * by_bias;
  joined.time_offset_s = first.time_offset_s;
  joined.by_time_offset = transition.topLeftCorner<9, 9>() * first.by_time_offset +
                          own.topLeftCorner<9, 9>() * second.by_time_offset;
  joined.covariance = transition * first.covariance * transition.transpose() +
                      own * second.covariance * own.transpose();
  return joined;
}

}  // namespace gluevo::vo
