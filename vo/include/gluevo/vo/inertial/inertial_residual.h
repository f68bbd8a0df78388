#pragma once

#include <Eigen/Core>

#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/inertial/preintegration.h"

namespace gluevo::vo {

/// What moves and what drifts, at one time.
struct InertialState {
  Rigid3 world_from_body;
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();  ///< m/s.
  ImuBias bias;
};

/// What an inertial unit adds to a frame's pose.
struct VelocityAndBias {
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();  ///< m/s.
  ImuBias bias;
};

/// A pose and what goes with it.
InertialState StateOf(const Rigid3& world_from_body, const VelocityAndBias& motion);

using InertialVector = Eigen::Matrix<double, kInertialTangentSize, 1>;

/// Position and velocity plus (world frame), rotation times exp (body frame), biases plus.
InertialState Plus(const InertialState& state, const InertialVector& delta);

/// How far two states contradict what was measured between them (Forster et al. 2017, eq. 45, and
/// the walk of the biases), in the order of inertial errors, metres, radians, m/s and so on.
struct InertialResidual {
  InertialVector value;
  InertialMatrix by_first;                                    ///< Derivative by Plus(first, delta).
  InertialMatrix by_second;                                   ///< By Plus(second, delta).
  Eigen::Matrix<double, kInertialTangentSize, 3> by_gravity;  ///< By gravity_in_world.
  InertialVector by_shift;                                    ///< By shift_s.
};

/// `gravity_in_world`: m/s^2, downwards. The residual is not whitened: its covariance is
/// `measured.covariance`. `shift_s`: by how much the time offset is larger than that of `measured`,
/// seconds.
InertialResidual ComputeInertialResidual(const InertialState& first, const InertialState& second,
                                         const Preintegration& measured,
                                         const Eigen::Vector3d& gravity_in_world,
                                         double shift_s = 0.0);

/// Where the first state leads.
InertialState Predict(const InertialState& first, const Preintegration& measured,
                      const Eigen::Vector3d& gravity_in_world);

}  // namespace gluevo::vo
