#include "gluevo/vo/pipeline/motion_history.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

namespace gluevo::vo {

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
  constexpr double kDecayS = 0.5;
  if (!last_but_one_) {
    return last_->world_from_body;
  }
  const auto seconds = [](int64_t from_ns, int64_t to_ns) {
    return static_cast<double>(to_ns - from_ns) * 1e-9;
  };
  const Rigid3 motion = last_but_one_->world_from_body.Inverse() * last_->world_from_body;
  const double moving_s =
      kDecayS * (1.0 - std::exp(-seconds(last_->timestamp_ns, timestamp_ns) / kDecayS));
  const double share = moving_s / seconds(last_but_one_->timestamp_ns, last_->timestamp_ns);
  Eigen::AngleAxisd turn(motion.rotation);
  turn.angle() *= share;
  return last_->world_from_body * Rigid3{Eigen::Quaterniond(turn), share * motion.translation};
}

}  // namespace gluevo::vo
