#pragma once

#include <Eigen/Core>
#include <optional>

#include "gluevo/vo/core/imu.h"

namespace gluevo::vo {

/// What an inertial unit and the images together say at a frame, besides its pose.
struct InertialEstimate {
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();  ///< m/s.
  Eigen::Vector3d gravity_in_world = Eigen::Vector3d::Zero();   ///< m/s^2, downwards.
  ImuBias bias;
  /// Standard deviations in the worst direction: m/s, radians, rad/s, m/s^2.
  double velocity_sigma = 0.0;
  double gravity_sigma = 0.0;
  double gyroscope_bias_sigma = 0.0;
  double accelerometer_bias_sigma = 0.0;
  /// Root mean squares of what the newest readings contradict, in standard deviations of the noise
  /// in use: rotation and the gyroscope's bias; position, velocity and the accelerometer's bias.
  double gyroscope_rms = 0.0;
  double accelerometer_rms = 0.0;
  /// Of the clocks, seconds: a reading that its unit stamps with t was taken at t less this in the
  /// images' clock. Nothing where it is not estimated. And its standard deviation.
  std::optional<double> time_offset_s = std::nullopt;
  double time_offset_sigma_s = 0.0;
};

}  // namespace gluevo::vo
