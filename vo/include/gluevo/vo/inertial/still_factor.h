#pragma once

#include <Eigen/Core>

#include "gluevo/vo/inertial/inertial_factor.h"
#include "gluevo/vo/inertial/inertial_residual.h"

// A body that does not move from one frame to the next (zero-velocity update; for inertial units
// and cameras as in Geneva et al., "OpenVINS", ICRA 2020).
namespace gluevo::vo {

/// The second frame's pose is the first one's, and it has no velocity, within these.
struct StillFactor {
  double position_sigma_m = 1.0;
  double rotation_sigma_rad = 1.0;
  double velocity_sigma = 1.0;  ///< m/s.
  double weight = 1.0;          ///< As InertialFactor's.
};

inline constexpr int kStillRows = 9;

/// Position, rotation, velocity in standard deviations, times the weight; derivatives by Plus().
struct StillResidual {
  Eigen::Matrix<double, kStillRows, 1> value;
  Eigen::Matrix<double, kStillRows, kInertialTangentSize> by_first;
  Eigen::Matrix<double, kStillRows, kInertialTangentSize> by_second;

  /// Half the sum of squares.
  double Cost() const { return 0.5 * value.squaredNorm(); }
};
StillResidual ComputeStillResidual(const StillFactor& factor, const InertialState& first,
                                   const InertialState& second);
/// Zeros where gravity stands, which has no part.
InertialNormalEquations NormalEquationsOf(const StillResidual& residual);

/// One factor of two that follow each other. What moves the body a little while it looks still may
/// go on: errors add up as they are, not as squares.
StillFactor Join(const StillFactor& first, const StillFactor& second);

}  // namespace gluevo::vo
