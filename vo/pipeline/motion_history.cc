#include "gluevo/vo/pipeline/motion_history.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "gluevo/vo/core/seconds.h"

namespace gluevo::vo {
namespace {

constexpr double kDecayS = 0.5;

// How long something moves that comes to rest, in times of its first speed.
double MovingS(double seconds) { return kDecayS * (1.0 - std::exp(-seconds / kDecayS)); }

}  // namespace

void MotionHistory::Add(const StampedPose& pose, bool starts_segment) {
  last_but_one_ = std::exchange(last_, pose);
  if (starts_segment) {
    last_but_one_.reset();
  }
}

std::vector<Rigid3> MotionHistory::Guesses() const {
  std::vector<Rigid3> guesses;
  if (last_) {
    guesses.push_back(last_->world_from_body);
  }
  if (last_but_one_) {
    guesses.push_back(last_->world_from_body * last_but_one_->world_from_body.Inverse() *
                      last_->world_from_body);
  }
  return guesses;
}

Rigid3 MotionHistory::Predict(int64_t timestamp_ns) const {
  if (!last_but_one_) {
    return last_->world_from_body;
  }
  const Rigid3 motion = last_but_one_->world_from_body.Inverse() * last_->world_from_body;
  const double share = MovingS(SecondsBetween(last_->timestamp_ns, timestamp_ns)) /
                       SecondsBetween(last_but_one_->timestamp_ns, last_->timestamp_ns);
  Eigen::AngleAxisd turn(motion.rotation);
  turn.angle() *= share;
  return last_->world_from_body * Rigid3{Eigen::Quaterniond(turn), share * motion.translation};
}

PoseCovariance MotionHistory::PredictionCovariance(int64_t timestamp_ns) const {
  constexpr double kAcceleration = 2.0;         // m/s^2, of people, cars and copters.
  constexpr double kAngularAcceleration = 2.0;  // rad/s^2.
  const double seconds = SecondsBetween(last_->timestamp_ns, timestamp_ns);
  const double pushed = 0.5 * seconds * seconds;
  double speed = 0.0;
  double turning_speed = 0.0;
  if (last_but_one_) {
    const double before = SecondsBetween(last_but_one_->timestamp_ns, last_->timestamp_ns);
    const Rigid3 motion = last_but_one_->world_from_body.Inverse() * last_->world_from_body;
    speed = motion.translation.norm() / before;
    turning_speed = Eigen::AngleAxisd(motion.rotation).angle() / before;
  }
  const double gone_on = seconds - MovingS(seconds);
  const double position = std::hypot(kAcceleration * pushed, speed * gone_on);
  const double rotation = std::hypot(kAngularAcceleration * pushed, turning_speed * gone_on);
  PoseCovariance covariance = PoseCovariance::Zero();
  covariance.diagonal() << Eigen::Vector3d::Constant(position * position),
      Eigen::Vector3d::Constant(rotation * rotation);
  return covariance;
}

}  // namespace gluevo::vo
