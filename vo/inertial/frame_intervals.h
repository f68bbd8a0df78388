#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/inertial/preintegration.h"

namespace gluevo::vo {

/// What the unit measured from one frame to the next.
struct FrameInterval {
  std::size_t first = 0;  ///< The earlier frame's index.
  Preintegration measured;
};

/// Whether samples reach from one time to the other without a gap of more than 0.1 s.
bool IsCovered(const std::vector<ImuSample>& samples, int64_t begin_ns, int64_t end_ns);

/// The intervals between frames that the samples cover without gaps of more than 0.1 s.
std::vector<FrameInterval> IntegrateIntervals(const Trajectory& frames,
                                              const std::vector<ImuSample>& samples,
                                              const ImuBias& bias, const ImuNoise& noise);

/// The root mean square of residuals whose squares sum up to `sum`, with so many degrees of
/// freedom: 1 where they are as large as their covariance says.
double Rms(double sum, Eigen::Index freedom);

}  // namespace gluevo::vo
