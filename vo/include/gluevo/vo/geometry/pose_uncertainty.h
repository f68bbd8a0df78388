#pragma once

#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo {

/// How the error of a_from_c follows from that of a_from_b, where b_from_c is right.
Eigen::Matrix<double, 6, 6> ErrorThrough(const Rigid3& b_from_c);

/// Of a_from_c = a_from_b * b_from_c, whose errors have nothing to do with each other.
PoseCovariance Compose(const PoseCovariance& of_a_from_b, const Rigid3& b_from_c,
                       const PoseCovariance& of_b_from_c);

/// The error of an estimate in the axes of its b: what a PoseCovariance is the covariance of.
Eigen::Matrix<double, 6, 1> ErrorOfPose(const Rigid3& estimated_a_from_b,
                                        const Rigid3& true_a_from_b);

}  // namespace gluevo::vo
