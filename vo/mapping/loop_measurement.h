#pragma once

#include "gluevo/vo/geometry/pose_uncertainty.h"
#include "gluevo/vo/mapping/loop_verification.h"

namespace gluevo::vo::internal {

/// One motion after the other.
inline LoopMeasurement Chained(const LoopMeasurement& first, const LoopMeasurement& second) {
  return {first.candidate_from_query * second.candidate_from_query,
          Compose(first.covariance, second.candidate_from_query, second.covariance)};
}

inline LoopMeasurement Inverted(const LoopMeasurement& motion) {
  const Rigid3 inverse = motion.candidate_from_query.Inverse();
  // The error of an inverse in its own axes is that of the motion, seen from the other end.
  const Eigen::Matrix<double, 6, 6> through = ErrorThrough(inverse);
  return {inverse, through * motion.covariance * through.transpose()};
}

}  // namespace gluevo::vo::internal
