#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/geometry/manifold.h"
#include "imu.h"
#include "path.h"

namespace gluevo::vo {

/// A path with the readings of an inertial unit on it and poses as stereo vision finds them: in a
/// frame of its own, with noise.
struct SimulatedMotion {
  static constexpr int64_t kImuStepNs = 1'000'000'000 / simulation::kImuRateHz;

  SimulatedMotion(simulation::SimulationPath flown, int seconds, unsigned seed)
      : path(std::move(flown)) {
    const auto readings =
        simulation::SimulateImu(path, seconds * simulation::kImuRateHz + 1, ImuNoise(), seed);
    samples.reserve(readings.size());
    biases.reserve(readings.size());
    for (std::size_t i = 0; i < readings.size(); ++i) {
      samples.push_back({static_cast<int64_t>(i) * kImuStepNs, readings[i].angular_velocity,
                         readings[i].specific_force});
      biases.push_back({readings[i].gyroscope_bias, readings[i].accelerometer_bias});
    }
  }

  /// `count` poses of world_from_body from `start_s` on, `step_s` apart.
  Trajectory Frames(double start_s, int count, double step_s, double position_sigma,
                    double rotation_sigma, unsigned seed) const {
    std::mt19937_64 generator(seed);
    std::normal_distribution<double> normal;
    Trajectory frames;
    frames.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      const auto time_ns = static_cast<int64_t>(std::llround(1e9 * (start_s + i * step_s)));
      PoseTangent noise;
      for (Eigen::Index k = 0; k < noise.size(); ++k) {
        noise[k] = (k < 3 ? position_sigma : rotation_sigma) * normal(generator);
      }
      const Rigid3 pose = vision_from_world * path(1e-9 * static_cast<double>(time_ns));
      frames.push_back({time_ns, Plus(pose, noise)});
    }
    return frames;
  }

  Eigen::Vector3d Gravity() const {
    return vision_from_world.rotation * Eigen::Vector3d(0.0, 0.0, -simulation::kSimulationGravity);
  }
  Eigen::Vector3d Velocity(int64_t time_ns) const {
    return vision_from_world.rotation *
           simulation::MotionAt(path, 1e-9 * static_cast<double>(time_ns)).velocity_in_world;
  }
  const ImuBias& Bias(int64_t time_ns) const {
    return biases[static_cast<std::size_t>(time_ns / kImuStepNs)];
  }

  simulation::SimulationPath path;
  std::vector<ImuSample> samples;
  std::vector<ImuBias> biases;  ///< Of each sample.
  Rigid3 vision_from_world = {
      Eigen::Quaterniond(Eigen::AngleAxisd(2.0, Eigen::Vector3d(1.0, -2.0, 0.5).normalized())),
      {3.0, -1.0, 2.0}};
};

/// Radians between two directions.
inline double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace gluevo::vo
