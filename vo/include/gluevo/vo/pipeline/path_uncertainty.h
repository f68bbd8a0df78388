#pragma once

#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo {

/// How well the poses of a segment are known in the frame of its first one: the motions from key
/// frame to key frame, each as good as the window knows it, one behind the other, as if their
/// errors had nothing to do with each other.
class PathUncertainty {
 public:
  /// A segment begins: its first pose is what all others are seen from, and a key frame.
  void Start() { *this = {}; }

  /// Of the newest pose, by its motion since the newest key frame before it. A key frame is what
  /// the next motions start at.
  PoseCovariance Add(const Rigid3& keyframe_from_body, const PoseCovariance& of_motion,
                     bool is_keyframe);
  /// Of a pose that goes on from the newest one that was added.
  PoseCovariance After(const Rigid3& newest_from_body, const PoseCovariance& of_motion) const;

 private:
  PoseCovariance keyframe_ = PoseCovariance::Zero();
  PoseCovariance newest_ = PoseCovariance::Zero();
};

}  // namespace gluevo::vo
