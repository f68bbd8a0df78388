#include <Eigen/LU>
#include <vector>

#include "gluevo/vo/core/median.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/pipeline/inertial_navigation.h"

// How the body turns by the gyroscope alone: long before the unit starts its turns are of use.
namespace gluevo::vo {
namespace {

using inertial_block::kRotation;

constexpr std::size_t kMostBiases = 15;

std::vector<double> Along(const std::deque<Eigen::Vector3d>& vectors, int axis) {
  std::vector<double> values;
  values.reserve(vectors.size());
  for (const Eigen::Vector3d& vector : vectors) {
    values.push_back(vector[axis]);
  }
  return values;
}

}  // namespace

void InertialNavigation::LearnBias(const Eigen::Vector3d& gyroscope_bias) {
  biases_.push_back(gyroscope_bias);
  if (biases_.size() > kMostBiases) {
    biases_.pop_front();
  }
}

void InertialNavigation::LearnTurn() {
  if (frames_.size() < 2) {
    return;
  }
  const StampedPose& before = frames_[frames_.size() - 2];
  const StampedPose& now = frames_.back();
  if (!readings_.Cover(before.timestamp_ns, now.timestamp_ns)) {
    return;
  }
  const Preintegration measured = readings_.Between(before.timestamp_ns, now.timestamp_ns, {});
  const Eigen::Quaterniond before_from_now =
      before.world_from_body.rotation.conjugate() * now.world_from_body.rotation;
  const Eigen::Matrix3d by_bias = measured.by_bias.block<3, 3>(kRotation, 0);
  LearnBias(by_bias.inverse() * LogSo3(measured.motion.rotation.conjugate() * before_from_now));
}

std::optional<Eigen::Quaterniond> InertialNavigation::Turn(int64_t begin_ns, int64_t end_ns) const {
  if (!readings_.Cover(begin_ns, end_ns)) {
    return std::nullopt;
  }
  // Beyond it is no bias: units or axes are wrong, or what was taken for the frames' turns.
  constexpr double kMost = 0.2;
  ImuBias bias;
  for (int axis = 0; axis < 3 && !biases_.empty(); ++axis) {
    bias.gyroscope[axis] = Median(Along(biases_, axis));
  }
  std::vector<double> deviations;
  for (const Eigen::Vector3d& other : biases_) {
    deviations.push_back((other - bias.gyroscope).norm());
  }
  if (Median(std::move(deviations)) > kMost || bias.gyroscope.norm() > kMost) {
    return std::nullopt;
  }
  return readings_.Between(begin_ns, end_ns, bias).motion.rotation;
}

}  // namespace gluevo::vo
