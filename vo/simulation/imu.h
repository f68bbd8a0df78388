#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "gluevo/vo/core/imu.h"
#include "path.h"

namespace gluevo::simulation {

inline constexpr int kImuRateHz = 200;

struct ImuSample {
  double time_s = 0.0;
  Eigen::Vector3d angular_velocity;    // rad/s, body, with bias and noise
  Eigen::Vector3d specific_force;      // m/s^2, body, with bias and noise
  Eigen::Vector3d gyroscope_bias;      // rad/s, true
  Eigen::Vector3d accelerometer_bias;  // m/s^2, true
};

/// Samples at k / kImuRateHz for k = 0 .. count - 1. Biases start at random (0.02 rad/s, 0.05 m/s^2
/// a side) and walk.
std::vector<ImuSample> SimulateImu(const SimulationPath& path, int count, const vo::ImuNoise& noise,
                                   uint64_t seed);

}  // namespace gluevo::simulation
