#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/inertial/inertial_residual.h"

namespace gluevo::vo {

/// A smooth flight whose poses, velocities and readings are known in closed form, and an inertial
/// unit on it with samples at 200 a second.
struct InertialFlight {
  static constexpr int64_t kStepNs = 5'000'000;

  InertialFlight(int seconds, const ImuNoise& noise, bool is_ideal, unsigned seed) {
    std::mt19937_64 generator(seed);
    std::normal_distribution<double> normal;
    const auto draw = [&](double deviation) {
      const double x = normal(generator);
      const double y = normal(generator);
      const double z = normal(generator);
      return Eigen::Vector3d(is_ideal ? 0.0 * x : deviation * x, is_ideal ? 0.0 : deviation * y,
                             is_ideal ? 0.0 : deviation * z);
    };
    const double root_rate = std::sqrt(1e9 / static_cast<double>(kStepNs));
    ImuBias bias = {draw(0.02), draw(0.05)};
    const int64_t count = seconds * (1'000'000'000 / kStepNs) + 1;
    samples.reserve(count);
    biases.reserve(count);
    for (int64_t i = 0; i < count; ++i) {
      const double t = Seconds(i * kStepNs);
      biases.push_back(bias);
      samples.push_back(
          {i * kStepNs,
           AngularVelocity(t) + bias.gyroscope + draw(noise.gyroscope_density * root_rate),
           Rotation(t).conjugate() * (Acceleration(t) - gravity) + bias.accelerometer +
               draw(noise.accelerometer_density * root_rate)});
      bias.gyroscope += draw(noise.gyroscope_random_walk / root_rate);
      bias.accelerometer += draw(noise.accelerometer_random_walk / root_rate);
    }
  }

  InertialState StateAt(int64_t time_ns) const {
    const double t = Seconds(time_ns);
    const auto before = static_cast<std::size_t>(time_ns / kStepNs);
    const std::size_t after = std::min(before + 1, biases.size() - 1);
    const double share = static_cast<double>(time_ns % kStepNs) / static_cast<double>(kStepNs);
    const auto between = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
      return Eigen::Vector3d(a + share * (b - a));
    };
    return {{Rotation(t), Position(t)},
            Velocity(t),
            {between(biases[before].gyroscope, biases[after].gyroscope),
             between(biases[before].accelerometer, biases[after].accelerometer)}};
  }

  Eigen::Vector3d gravity = {0.0, 0.0, -9.81};
  std::vector<ImuSample> samples;
  std::vector<ImuBias> biases;  ///< Of each sample.

 private:
  static double Seconds(int64_t time_ns) { return 1e-9 * static_cast<double>(time_ns); }
  static Eigen::Vector3d Position(double t) {
    return {2.0 * std::sin(0.7 * t), 1.5 * std::cos(0.9 * t), 0.5 * std::sin(1.3 * t)};
  }
  static Eigen::Vector3d Velocity(double t) {
    return {1.4 * std::cos(0.7 * t), -1.35 * std::sin(0.9 * t), 0.65 * std::cos(1.3 * t)};
  }
  static Eigen::Vector3d Acceleration(double t) {
    return {-0.98 * std::sin(0.7 * t), -1.215 * std::cos(0.9 * t), -0.845 * std::sin(1.3 * t)};
  }
  // A turn about the vertical, then about the body's x axis: rates add up in the body frame.
  static double Yaw(double t) { return 0.8 * std::sin(0.5 * t); }
  static double Roll(double t) { return 0.4 * std::sin(1.1 * t); }
  static Eigen::Quaterniond Rotation(double t) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(Yaw(t), Eigen::Vector3d::UnitZ()) *
                              Eigen::AngleAxisd(Roll(t), Eigen::Vector3d::UnitX()));
  }
  static Eigen::Vector3d AngularVelocity(double t) {
    const double yaw_rate = 0.4 * std::cos(0.5 * t);
    const double roll_rate = 0.44 * std::cos(1.1 * t);
    return Eigen::Vector3d(roll_rate, yaw_rate * std::sin(Roll(t)), yaw_rate * std::cos(Roll(t)));
  }
};

}  // namespace gluevo::vo
