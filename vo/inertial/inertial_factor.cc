#include "gluevo/vo/inertial/inertial_factor.h"

#include <Eigen/Cholesky>

#include "gluevo/nn/error.h"
#include "gluevo/vo/inertial/gravity.h"

namespace gluevo::vo {

InertialFactor MakeInertialFactor(const Preintegration& measured, double weight) {
  const Eigen::LLT<InertialMatrix> covariance(measured.covariance);
  if (covariance.info() != Eigen::Success) {
    throw Error("inertial factor: a covariance that is not positive definite");
  }
  InertialFactor factor{measured, weight * InertialMatrix::Identity(), weight};
  covariance.matrixL().solveInPlace(factor.whitening);
  return factor;
}

WhitenedInertialResidual Whitened(const InertialFactor& factor, const InertialState& first,
                                  const InertialState& second,
                                  const Eigen::Vector3d& gravity_in_world,
                                  const std::optional<double>& time_offset_s) {
  const InertialResidual residual = ComputeInertialResidual(
      first, second, factor.measured, gravity_in_world, ShiftTo(time_offset_s, factor.measured));
  const auto whitening = factor.whitening.triangularView<Eigen::Lower>();
  WhitenedInertialResidual whitened;
  whitened.value = whitening * residual.value;
  whitened.by_first = whitening * residual.by_first;
  whitened.by_second = whitening * residual.by_second;
  whitened.by_gravity = whitening * (residual.by_gravity * GravityTangent(gravity_in_world));
  whitened.by_time_offset = whitening * residual.by_shift;
  return whitened;
}

double ShiftTo(const std::optional<double>& time_offset_s, const Preintegration& measured) {
  return time_offset_s ? *time_offset_s - measured.time_offset_s : 0.0;
}

WhitenedInertialResidual WhitenedAt(const InertialFactor& factor, const InertialState& first,
                                    const InertialState& second,
                                    const Eigen::Vector3d& gravity_in_world,
                                    const InertialState& linearization_of_first,
                                    const InertialState& linearization_of_second,
                                    const Eigen::Vector3d& linearization_of_gravity) {
  WhitenedInertialResidual whitened =
      Whitened(factor, linearization_of_first, linearization_of_second, linearization_of_gravity);
  whitened.value = factor.whitening.triangularView<Eigen::Lower>() *
                   ComputeInertialResidual(first, second, factor.measured, gravity_in_world).value;
  return whitened;
}

InertialNormalEquations NormalEquationsOf(const WhitenedInertialResidual& residual) {
  Eigen::Matrix<double, kInertialTangentSize, kInertialColumns> jacobian;
  jacobian << residual.by_first, residual.by_second, residual.by_gravity;
  return {jacobian.transpose() * jacobian, jacobian.transpose() * residual.value};
}

bool IsBiasFar(const Preintegration& measured, const ImuBias& bias) {
  constexpr double kGyroscope = 0.01;
  constexpr double kAccelerometer = 0.1;
  return (bias.gyroscope - measured.bias.gyroscope).norm() > kGyroscope ||
         (bias.accelerometer - measured.bias.accelerometer).norm() > kAccelerometer;
}

}  // namespace gluevo::vo
