#pragma once

#include <Eigen/Core>

#include "gluevo/vo/estimator/bend_evidence.h"
#include "gluevo/vo/geometry/stereo_correction.h"

namespace gluevo::vo {

/// What windows have learned of the right camera. It outlives each of them: a new segment goes on
/// from there.
struct StereoCalibration {
  StereoCorrection correction;
  /// Of the correction's turn, one standard deviation on each axis as residuals have it, radians.
  Eigen::Vector3d turn_sigma = Eigen::Vector3d::Zero();
  BendEvidence bend;
  int frames_to_weigh = 0;  ///< Until the bend is weighed again.
};

}  // namespace gluevo::vo
