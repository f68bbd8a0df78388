#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/trajectory.h"

namespace gluevo::vo {

/// The newest poses, from which the next one is guessed.
class MotionHistory {
 public:
  /// `starts_segment`: what came before has nothing to do with how the rig moves since.
  void Add(const StampedPose& pose, bool starts_segment);

  /// Nothing before the first pose.
  const std::optional<StampedPose>& last() const { return last_; }
  /// Where the rig may be one frame later: at rest, and, where the segment has two poses, after the
  /// last motion once more. Guesses only: RANSAC finds motions that are neither.
  std::vector<Rigid3> Guesses() const;
  /// Where it goes from the last pose by `timestamp_ns` if it moves on and comes to rest within a
  /// second or so. There must be a last pose.
  Rigid3 Predict(int64_t timestamp_ns) const;
  /// How good the prediction is, of its motion since the last pose: the rig may have gone on as it
  /// was going, or have been pushed.
  PoseCovariance PredictionCovariance(int64_t timestamp_ns) const;

 private:
  std::optional<StampedPose> last_, last_but_one_;
};

}  // namespace gluevo::vo
