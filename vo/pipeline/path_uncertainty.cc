#include "gluevo/vo/pipeline/path_uncertainty.h"

#include "gluevo/vo/geometry/pose_uncertainty.h"

namespace gluevo::vo {

PoseCovariance PathUncertainty::Add(const Rigid3& keyframe_from_body,
                                    const PoseCovariance& of_motion, bool is_keyframe) {
  newest_ = Compose(keyframe_, keyframe_from_body, of_motion);
  if (is_keyframe) {
    keyframe_ = newest_;
  }
  return newest_;
}

PoseCovariance PathUncertainty::After(const Rigid3& newest_from_body,
                                      const PoseCovariance& of_motion) const {
  return Compose(newest_, newest_from_body, of_motion);
}

}  // namespace gluevo::vo
