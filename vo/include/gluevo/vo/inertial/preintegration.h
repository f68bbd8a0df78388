#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "gluevo/vo/core/imu.h"

// Samples between two frames become one measurement (Forster et al., "On-Manifold Preintegration",
// T-RO 2017; by the midpoint rule as Qin et al., "VINS-Mono", T-RO 2018).
namespace gluevo::vo {

/// Rows and columns of inertial errors: position, rotation (right, radians), velocity, gyroscope's
/// and accelerometer's bias, three each.
inline constexpr int kInertialTangentSize = 15;
using InertialMatrix = Eigen::Matrix<double, kInertialTangentSize, kInertialTangentSize>;
namespace inertial_block {
inline constexpr int kPosition = 0;
inline constexpr int kRotation = 3;
inline constexpr int kVelocity = 6;
inline constexpr int kGyroscopeBias = 9;
inline constexpr int kAccelerometerBias = 12;
}  // namespace inertial_block

/// Motion between the two times as the sensors alone see it, in the body frame of the first: what
/// velocity and gravity add is left out (Forster et al., eq. 33).
struct InertialMotion {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< begin_from_end.
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();            ///< m/s.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();            ///< Metres.
};

struct Preintegration {
  double duration_s = 0.0;
  ImuBias bias;           ///< That `motion` was integrated with.
  InertialMotion motion;  ///< For that bias.
  /// Derivatives of `motion` (rows as inertial errors, the first nine) by the gyroscope's and the
  /// accelerometer's bias.
  Eigen::Matrix<double, 9, 6> by_bias = Eigen::Matrix<double, 9, 6>::Zero();
  /// Derivative of `motion` by the time offset of ImuReadings, 1/s: by how both ends of the
  /// interval move along the readings.
  Eigen::Matrix<double, 9, 1> by_time_offset = Eigen::Matrix<double, 9, 1>::Zero();
  double time_offset_s = 0.0;  ///< That `motion` was integrated with, see ImuReadings.
  /// Of the error of `motion` and of the biases' walk up to the second time; positive definite.
  InertialMatrix covariance = InertialMatrix::Zero();

  /// The motion for another bias, to first order: good to 1e-4 rad and 1e-3 m where the bias is
  /// within 0.01 rad/s and 0.1 m/s^2 of that of the integration, for a second.
  InertialMotion At(const ImuBias& other) const;
  /// Likewise for a time offset that is `shift_s` larger than that of the integration: good to
  /// 1e-5 rad and 1e-4 m within 0.5 ms, for flights' accelerations. A shift of zero changes
  /// nothing.
  InertialMotion At(const ImuBias& other, double shift_s) const;
};

/// Integrates from begin_ns to end_ns samples in order of time, of which one is at or before the
/// first and one at or after the second; values at both times are interpolated. Throws Error where
/// they do not cover the interval, are out of order, or where begin_ns is not before end_ns.
Preintegration Preintegrate(const std::vector<ImuSample>& samples, int64_t begin_ns, int64_t end_ns,
                            const ImuBias& bias, const ImuNoise& noise);

/// What is known between two times where samples are missing: how far the biases may have walked.
/// Of the motion nothing is (ten kilometres, ten radians).
Preintegration AcrossGap(double duration_s, const ImuBias& bias, const ImuNoise& noise);

/// One measurement of two that follow each other, as where the frame between them is dropped: the
/// same as integrating over both, to rounding where both were integrated with the same bias. Else
/// the second is brought to the first one's bias and time offset, to first order
/// (Preintegration::At).
Preintegration Join(const Preintegration& first, const Preintegration& second);

}  // namespace gluevo::vo
