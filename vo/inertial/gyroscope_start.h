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
  /// On top of that of the integrations, and its standard deviation, seconds; zeros where it is not
  /// estimated.
  double time_offset_s = 0.0;
  double time_offset_sigma_s = 0.0;
};

/// The gyroscope's bias, and with InitialisationOptions::time_offset_sigma_s the time offset, of
/// which the integrations have `time_offset_so_far_s` in them already, from the frames' rotations,
/// by Gauss and Newton. What vision has wrong in a frame is in two intervals, with opposite signs:
/// the frames' turns are estimated beside the bias, within vision's uncertainty.
GyroscopeStart EstimateGyroscopeBias(const Trajectory& frames,
                                     const std::vector<FrameInterval>& intervals,
                                     const InitialisationOptions& options,
                                     double time_offset_so_far_s = 0.0);

}  // namespace gluevo::vo
