#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/core/trajectory.h"

namespace gluevo::vo {

/// What vision says of the gyroscope: its unit and how it is mounted.
struct GyroscopeCheck {
  std::size_t turns = 0;  ///< Between frames that follow each other, that were large enough.
  /// Median of what the gyroscope turned over what vision turned: 1, or 57.3 for degrees.
  double scale = 1.0;
  /// The rotation that takes the gyroscope's axes to the body's best (Kabsch 1976); the least one
  /// where all turns were about one axis.
  Eigen::Quaterniond body_from_gyroscope = Eigen::Quaterniond::Identity();
  /// The share of the turns' squares that this rotation leaves, at that scale: near 0 where both
  /// saw the same motion, near 1 where they have nothing in common.
  double unexplained = 0.0;
  /// What is wrong, a sentence; empty where nothing is, or too few turns were seen to tell.
  std::string fault;
  /// The rates are degrees a second: what has to be multiplied by pi / 180.
  bool is_degrees = false;
};

/// Compares the turns between frames (world_from_body) with the samples, which are along the body's
/// axes. At least ten turns of more than a degree are needed to tell anything; a bias of some
/// hundredths of a rad/s does no harm.
GyroscopeCheck CheckGyroscope(const Trajectory& frames, const std::vector<ImuSample>& samples);

}  // namespace gluevo::vo
