#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "path.h"

namespace gluevo::simulation {

/// Noise of EuRoC's inertial unit (ADIS16448, sensor.yaml of its recordings), continuous time.
struct ImuNoise {
  double gyroscope_density = 1.6968e-4;       // rad/s/sqrt(Hz)
  double gyroscope_random_walk = 1.9393e-5;   // rad/s^2/sqrt(Hz)
  double accelerometer_density = 2.0e-3;      // m/s^2/sqrt(Hz)
  double accelerometer_random_walk = 3.0e-3;  // m/s^3/sqrt(Hz)
};

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
std::vector<ImuSample> SimulateImu(const SimulationPath& path, int count, const ImuNoise& noise,
                                   uint64_t seed);

}  // namespace gluevo::simulation
