#include <cmath>

#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/geometry/eigen_solvers.h"
#include "gluevo/vo/pipeline/inertial_navigation.h"

// The unit outlives a loss of the frames' poses: the gyroscope carries gravity's direction on.
namespace gluevo::vo {
namespace {

using inertial_block::kRotation;

double Square(double value) { return value * value; }

}  // namespace

void InertialNavigation::Keep(int64_t timestamp_ns, const Eigen::Quaterniond& world_from_body,
                              const InertialEstimate& estimate) {
  kept_ = {timestamp_ns, world_from_body.conjugate() * estimate.gravity_in_world, estimate};
  LearnBias(estimate.bias.gyroscope);
}

std::optional<InertialStart> InertialNavigation::TryKept() {
  constexpr std::size_t kFewest = 3;
  constexpr double kLongestS = 30.0;
  constexpr double kMostTurnError = 0.02;  // Radians, of what the frames saw.
  if (!kept_ || frames_.size() < kFewest) {
    return std::nullopt;
  }
  const Kept kept = *kept_;
  kept_.reset();
  const StampedPose& first = frames_.front();
  const StampedPose& now = frames_.back();
  const double seconds = SecondsBetween(kept.timestamp_ns, now.timestamp_ns);
  if (seconds > kLongestS || !readings_.Cover(kept.timestamp_ns, now.timestamp_ns)) {
    return std::nullopt;
  }
  const ImuBias& bias = kept.estimate.bias;
  const Eigen::Quaterniond seen =
      first.world_from_body.rotation.conjugate() * now.world_from_body.rotation;
  if (readings_.Between(first.timestamp_ns, now.timestamp_ns, bias)
          .motion.rotation.angularDistance(seen) > kMostTurnError) {
    return std::nullopt;
  }
  const Preintegration since = readings_.Between(kept.timestamp_ns, now.timestamp_ns, bias);
  InertialStart start;
  start.bias = bias;
  start.gravity_in_world =
      now.world_from_body.rotation * (since.motion.rotation.conjugate() * kept.gravity_in_body);
  start.gravity_sigma = std::sqrt(
      Square(kept.estimate.gravity_sigma) + Square(seconds * kept.estimate.gyroscope_bias_sigma) +
      Square(WorstSigma(since.covariance.block<3, 3>(kRotation, kRotation))));
  if (start.gravity_sigma > options_.start.largest_gravity_sigma) {
    return std::nullopt;
  }
  const ImuNoise& noise = readings_.noise();
  const double gyroscope =
      Square(kept.estimate.gyroscope_bias_sigma) + Square(noise.gyroscope_random_walk) * seconds;
  const double accelerometer = Square(kept.estimate.accelerometer_bias_sigma) +
                               Square(noise.accelerometer_random_walk) * seconds;
  start.covariance.diagonal() << Eigen::Vector3d::Constant(gyroscope),
      Eigen::Vector3d::Constant(accelerometer),
      Eigen::Vector2d::Constant(Square(start.gravity_sigma));
  start.time_offset_sigma_s = options_.start.time_offset_sigma_s;
  return start;
}

}  // namespace gluevo::vo
