#include "gluevo/vo/pipeline/path_uncertainty.h"

#include "gluevo/vo/geometry/pose_uncertainty.h"

namespace gluevo::vo {

void PathUncertainty::Start(const Rigid3& world_from_body) {
  keyframe_ = newest_ = {world_from_body};
}

PoseCovariance PathUncertainty::Add(const Rigid3& world_from_body, const PoseCovariance& of_motion,
                                    bool is_keyframe) {
  newest_ = {world_from_body, From(keyframe_, world_from_body, of_motion)};
  if (is_keyframe) {
    keyframe_ = newest_;
  }
  return newest_.covariance;
}

PoseCovariance PathUncertainty::After(const Rigid3& world_from_body,
                                      const PoseCovariance& of_motion) const {
  return From(newest_, world_from_body, of_motion);
}

PoseCovariance PathUncertainty::From(const Known& known, const Rigid3& world_from_body,
                                     const PoseCovariance& of_motion) {
  return Compose(known.covariance, known.world_from_body.Inverse() * world_from_body, of_motion);
}

}  // namespace gluevo::vo
