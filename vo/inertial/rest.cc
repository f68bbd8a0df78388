#include "gluevo/vo/inertial/rest.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/inertial/gravity.h"

namespace gluevo::vo {
namespace {

using Readings = Eigen::Matrix<double, 6, 1>;

Readings ReadingsOf(const ImuSample& sample) {
  Readings readings;
  readings << sample.angular_velocity, sample.specific_force;
  return readings;
}

}  // namespace

void RestOptions::Validate() const {
  CheckPositive(duration_s, "rest duration_s");
  CheckPositive(block_s, "rest block_s");
  CheckWithin(block_s, 0.0, 0.5 * duration_s, "rest block_s");
  CheckPositive(largest_rate_deviation, "rest largest_rate_deviation");
  CheckPositive(largest_force_deviation, "rest largest_force_deviation");
}

std::optional<ImuRest> FindRest(const std::vector<ImuSample>& samples, int64_t end_ns,
                                bool images_are_still, const RestOptions& options) {
  options.Validate();
  if (!images_are_still) {
    return std::nullopt;
  }
  constexpr double kSecondNs = 1e9;
  const int blocks = static_cast<int>(std::floor(options.duration_s / options.block_s));
  const int64_t block_ns = std::llround(kSecondNs * options.duration_s / blocks);
  const auto at = [&](int64_t time_ns) {
    return std::lower_bound(
        samples.begin(), samples.end(), time_ns,
        [](const ImuSample& sample, int64_t time) { return sample.timestamp_ns < time; });
  };
  std::vector<Readings> means;
  means.reserve(static_cast<std::size_t>(blocks));
  Readings mean = Readings::Zero();
  for (int i = blocks; i > 0; --i) {
    const auto begin = at(end_ns - i * block_ns);
    const auto end = at(end_ns - (i - 1) * block_ns);
    // Most of the block, and more than chance.
    constexpr std::ptrdiff_t kFewest = 4;
    constexpr double kMost = 0.8;
    if (end - begin < kFewest ||
        static_cast<double>((end - 1)->timestamp_ns - begin->timestamp_ns) <
            kMost * static_cast<double>(block_ns)) {
      return std::nullopt;
    }
    Readings sum = Readings::Zero();
    for (auto sample = begin; sample != end; ++sample) {
      sum += ReadingsOf(*sample);
    }
    means.emplace_back(sum / static_cast<double>(end - begin));
    mean += means.back() / blocks;
  }
  Readings variance = Readings::Zero();
  for (const Readings& block : means) {
    variance += (block - mean).cwiseAbs2() / std::max(1, blocks - 1);
  }
  const double rate_deviation = std::sqrt(variance.head<3>().maxCoeff());
  const double force_deviation = std::sqrt(variance.tail<3>().maxCoeff());
  if (rate_deviation > options.largest_rate_deviation ||
      force_deviation > options.largest_force_deviation) {
    return std::nullopt;
  }
  const double root = std::sqrt(static_cast<double>(blocks));
  return ImuRest{mean.head<3>(), mean.tail<3>(), rate_deviation / root, force_deviation / root,
                 end_ns - blocks * block_ns};
}

InertialStart StartAtRest(const ImuRest& rest, const Rigid3& world_from_body,
                          const InitialisationOptions& options) {
  options.Validate();
  InertialStart start;
  start.free_gravity = rest.specific_force.norm();
  if (std::abs(start.free_gravity - options.gravity) >
      options.largest_gravity_error * options.gravity) {
    start.refused = "at rest the accelerometer shows " + ShortText(start.free_gravity, 4) +
                    " m/s^2, expected gravity, " + ShortText(options.gravity, 4);
    return start;
  }
  const Eigen::Vector3d up = rest.specific_force.normalized();
  start.gravity_in_world = -options.gravity * (world_from_body.rotation * up);
  start.velocities_in_world = {Eigen::Vector3d::Zero()};
  start.rest_begin_ns = rest.begin_ns;
  start.bias.gyroscope = rest.angular_velocity;
  start.bias.accelerometer = (start.free_gravity - options.gravity) * up;
  // A tilt and a bias that is level make up for each other; upright the length tells.
  const double bias = options.accelerometer_bias_sigma;
  const double noise = rest.force_sigma * rest.force_sigma;
  start.gravity_sigma = std::sqrt(bias * bias + noise) / options.gravity;
  start.covariance.topLeftCorner<3, 3>().diagonal().setConstant(rest.rate_sigma * rest.rate_sigma);
  const Eigen::Matrix3d level = Eigen::Matrix3d::Identity() - up * up.transpose();
  start.covariance.block<3, 3>(3, 3) = bias * bias * level + noise * up * up.transpose();
  // force = bias - R^T gravity stays as it is: gravity moves by R times what the bias does.
  const Eigen::Matrix<double, 2, 3> turn_by_bias =
      GravityTangent(start.gravity_in_world).transpose() *
      world_from_body.rotation.toRotationMatrix() / (options.gravity * options.gravity);
  start.covariance.block<2, 3>(6, 3) = bias * bias * turn_by_bias * level;
  start.covariance.block<3, 2>(3, 6) = start.covariance.block<2, 3>(6, 3).transpose();
  start.covariance.bottomRightCorner<2, 2>().diagonal().setConstant(start.gravity_sigma *
                                                                    start.gravity_sigma);
  return start;
}

}  // namespace gluevo::vo
