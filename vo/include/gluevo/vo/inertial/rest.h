#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/inertial/initialisation.h"

namespace gluevo::vo {

/// When a body is at rest. What motors shake is there at rest, too, and averages out over a block;
/// on EuRoC's V1_01 the means of blocks deviate by 0.01 rad/s and 0.12 m/s^2 before the take-off,
/// by ten times as much in flight.
struct RestOptions {
  double duration_s = 0.5;
  double block_s = 0.1;
  double largest_rate_deviation = 0.02;  ///< Of the blocks' means, an axis, rad/s.
  double largest_force_deviation = 0.2;  ///< m/s^2.

  /// Throws Error naming the figure that is out of range.
  void Validate() const;
};

/// What both sensors show at rest.
struct ImuRest {
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< Mean, rad/s: the bias.
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();    ///< Mean, m/s^2.
  double rate_sigma = 0.0;   ///< Of the mean, the axis that is known least.
  double force_sigma = 0.0;  ///< Likewise.
  int64_t begin_ns = 0;
};

/// Whether the body was at rest until `end_ns`. A constant turn looks like a bias: nothing unless
/// the images are still, too, which is the caller's to say. Nothing either where the samples do not
/// cover the time, but for a tenth of it.
std::optional<ImuRest> FindRest(const std::vector<ImuSample>& samples, int64_t end_ns,
                                bool images_are_still, const RestOptions& options);

/// A start from rest: gravity and the gyroscope's bias by the means, velocity zero (one entry), the
/// accelerometer's bias along gravity by its length. How well gravity's direction is known is up to
/// the accelerometer's bias; that does not refuse it here. Refused where the force is no gravity.
InertialStart StartAtRest(const ImuRest& rest, const Rigid3& world_from_body,
                          const InitialisationOptions& options);

}  // namespace gluevo::vo
