#pragma once

#include <Eigen/Core>

#include "gluevo/vo/estimator/bend_evidence.h"
#include "gluevo/vo/geometry/stereo_correction.h"

namespace gluevo::vo {

/// What windows have learned of the right camera. It outlives each of them: a new segment goes on
/// from there.
struct StereoCalibration {
  /// What is made up for: nothing until the calibration is surely off.
  StereoCorrection correction;
  bool is_off = false;
  /// Frames enough have been seen: what is below is an estimate.
  bool is_known = false;
  /// What views ask for as the correction's turn, made up for or not, radians.
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  /// Of `turn`, one standard deviation on each axis as residuals have it, radians.
  Eigen::Vector3d turn_sigma = Eigen::Vector3d::Zero();
  BendEvidence bend;
  int frames_to_weigh = 0;  ///< Until the bend is weighed again.
};

}  // namespace gluevo::vo
