#include "gluevo/vo/pipeline/motion_history.h"

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

}  // namespace gluevo::vo
