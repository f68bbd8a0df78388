#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "gluevo/vo/core/options_check.h"

namespace gluevo::vo {

/// What an inertial unit measures at a time, in its own frame, which is the rig's body.
struct ImuSample {
  int64_t timestamp_ns = 0;
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< rad/s.
  /// Acceleration minus gravity, m/s^2: 9.81 upwards at rest.
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();
};

/// Densities of noise in continuous time, as sensor.yaml (EuRoC) and imu.yaml (Kalibr) give them.
/// The defaults are EuRoC's (ADIS16448).
struct ImuNoise {
  double gyroscope_density = 1.6968e-4;       ///< rad/s/sqrt(Hz)
  double gyroscope_random_walk = 1.9393e-5;   ///< rad/s^2/sqrt(Hz)
  double accelerometer_density = 2.0e-3;      ///< m/s^2/sqrt(Hz)
  double accelerometer_random_walk = 3.0e-3;  ///< m/s^3/sqrt(Hz)

  /// Throws Error naming the figure that is not positive.
  void Validate() const {
    CheckPositive(gyroscope_density, "gyroscope_density");
    CheckPositive(gyroscope_random_walk, "gyroscope_random_walk");
    CheckPositive(accelerometer_density, "accelerometer_density");
    CheckPositive(accelerometer_random_walk, "accelerometer_random_walk");
  }
};

/// What both sensors show too much, in the body frame.
struct ImuBias {
  Eigen::Vector3d gyroscope = Eigen::Vector3d::Zero();      ///< rad/s.
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  ///< m/s^2.
};

}  // namespace gluevo::vo
