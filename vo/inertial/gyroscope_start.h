#pragma once

#include <Eigen/Core>
#include <vector>

#include "frame_intervals.h"
#include "gluevo/vo/inertial/initialisation.h"

namespace gluevo::vo {

struct GyroscopeStart {
  /// rad/s, on top of that of the integrations.
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  double rms = 0.0;  ///< Of the residuals, in standard deviations.
};

/// The gyroscope's bias from the frames' rotations, by Gauss and Newton. What vision has wrong in a
/// frame is in two intervals, with opposite signs: the frames' turns are estimated beside the bias,
/// within vision's uncertainty.
GyroscopeStart EstimateGyroscopeBias(const Trajectory& frames,
                                     const std::vector<FrameInterval>& intervals,
                                     const InitialisationOptions& options);

}  // namespace gluevo::vo
