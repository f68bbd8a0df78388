#pragma once

#include <Eigen/Core>
#include <optional>

#include "gluevo/vo/inertial/inertial_residual.h"
#include "gluevo/vo/inertial/preintegration.h"

// What a preintegration says of the states at both its ends, for a solver of dense blocks. A
// state's tangent is that of Plus: the six of the pose first, then velocity and biases.
namespace gluevo::vo {

/// A preintegration and the square root of its information: whitening^T whitening is the inverse of
/// its covariance, times weight^2.
struct InertialFactor {
  Preintegration measured;
  InertialMatrix whitening = InertialMatrix::Zero();  ///< Lower triangle.
  double weight = 1.0;
};

/// `weight`: where other residuals are divided by a noise that is not theirs, their real noise over
/// that one; only what they are worth to each other counts. Throws Error where the covariance is
/// not positive definite: what was integrated is no time.
InertialFactor MakeInertialFactor(const Preintegration& measured, double weight = 1.0);

/// The residual and its derivatives in standard deviations, times the factor's weight.
struct WhitenedInertialResidual {
  InertialVector value;
  InertialMatrix by_first;
  InertialMatrix by_second;
  /// By the turn of gravity (TurnedGravity), radians.
  Eigen::Matrix<double, kInertialTangentSize, 2> by_gravity;
  InertialVector by_time_offset;  ///< A second.

  /// Half the sum of squares.
  double Cost() const { return 0.5 * value.squaredNorm(); }
};

/// `time_offset_s`: that of ImuReadings; nothing where it is not estimated.
WhitenedInertialResidual Whitened(const InertialFactor& factor, const InertialState& first,
                                  const InertialState& second,
                                  const Eigen::Vector3d& gravity_in_world,
                                  const std::optional<double>& time_offset_s = std::nullopt);
/// Of the measurement's own time offset, seconds; zero where it is not estimated.
double ShiftTo(const std::optional<double>& time_offset_s, const Preintegration& measured);

/// The value at the present states with derivatives at those where they came into the prior
/// (first-estimates Jacobians, Huang et al. 2010): were derivatives by one state taken at two
/// places, their sum would claim to know yaw and place, of which nothing was measured. Pass the
/// present state, and the present gravity, for what is in no prior.
WhitenedInertialResidual WhitenedAt(const InertialFactor& factor, const InertialState& first,
                                    const InertialState& second,
                                    const Eigen::Vector3d& gravity_in_world,
                                    const InertialState& linearization_of_first,
                                    const InertialState& linearization_of_second,
                                    const Eigen::Vector3d& linearization_of_gravity);

/// Both states, then gravity's turn.
inline constexpr int kInertialColumns = 2 * kInertialTangentSize + 2;

/// J^T J (whole) and J^T r.
struct InertialNormalEquations {
  Eigen::Matrix<double, kInertialColumns, kInertialColumns> hessian;
  Eigen::Matrix<double, kInertialColumns, 1> gradient;
};
InertialNormalEquations NormalEquationsOf(const WhitenedInertialResidual& residual);

/// Whether a bias is so far from that of the integration that its first order errs by more than the
/// sensors do: 0.01 rad/s or 0.1 m/s^2. The samples have to be integrated again then.
bool IsBiasFar(const Preintegration& measured, const ImuBias& bias);

}  // namespace gluevo::vo
