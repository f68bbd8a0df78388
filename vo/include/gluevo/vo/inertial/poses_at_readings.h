#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/inertial/imu_readings.h"
#include "gluevo/vo/inertial/inertial_residual.h"

namespace gluevo::vo {

/// A state at a frame's time.
struct StampedInertialState {
  int64_t timestamp_ns = 0;
  InertialState state;
};

/// Poses at the times of the readings after the first frame up to the second: where the first
/// frame's state leads, and what the second frame's pose differs from that spread evenly over the
/// time, so that the path goes through both. Empty where the readings do not cover the time
/// between, or where the second frame is not after the first.
Trajectory PosesAtReadings(const StampedInertialState& first, const StampedPose& second,
                           const Eigen::Vector3d& gravity_in_world, const ImuReadings& readings);

}  // namespace gluevo::vo
