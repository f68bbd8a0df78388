#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/core/trajectory.h"

// How an inertial unit starts beside stereo cameras, which know the scale: all is linear but the
// gyroscope's bias (Qin et al., "VINS-Mono", T-RO 2018, section V-B, without the scale; uncertainty
// as Campos et al., "Inertial-Only Optimization for Visual-Inertial Initialization", ICRA 2020,
// ask for).
namespace gluevo::vo {

struct InitialisationOptions {
  double gravity = 9.80665;  ///< Its length, m/s^2.
  /// How far poses from vision are off from each other, metres and radians a frame.
  double vision_position_sigma = 0.003;
  double vision_rotation_sigma = 0.001;
  /// What is known of the biases beforehand, rad/s and m/s^2 an axis. Without rotation the
  /// accelerometer's cannot be told from a tilt: this alone then limits how well gravity is known.
  double gyroscope_bias_sigma = 0.1;
  double accelerometer_bias_sigma = 0.2;
  /// What is known of the time offset of ImuReadings beforehand, seconds: that it is zero within
  /// this. 0: it is not estimated.
  double time_offset_sigma_s = 0.0;

  /// What a start needs: this long, ...
  double least_duration_s = 1.0;
  /// ... gravity's direction this well known, radians (a degree), ...
  double largest_gravity_sigma = 0.0174533;
  /// ... its length this near to what it is, before that is imposed, as a share of it, ...
  double largest_gravity_error = 0.05;
  /// ... and residuals of this many standard deviations at most (root mean square).
  double largest_rms = 3.0;

  /// Throws Error naming the figure that is out of range.
  void Validate() const;
};

/// What is known where inertial navigation begins. The world is that of the poses from vision.
struct InertialStart {
  ImuBias bias;
  Eigen::Vector3d gravity_in_world = Eigen::Vector3d::Zero();  ///< m/s^2, downwards.
  std::vector<Eigen::Vector3d> velocities_in_world;            ///< m/s, one a frame.
  std::optional<int64_t> rest_begin_ns;                        ///< Nothing in motion.

  /// On top of that of the samples, and its standard deviation; zeros where it is not estimated.
  double time_offset_s = 0.0;
  double time_offset_sigma_s = 0.0;

  /// Of the gyroscope's and the accelerometer's bias, rad/s and m/s^2, and of gravity's direction
  /// (GravityTangent), radians: a tilt and a bias that make up for each other are known together.
  Eigen::Matrix<double, 8, 8> covariance = Eigen::Matrix<double, 8, 8>::Zero();
  /// Standard deviation of gravity's direction along the axis where it is known least, radians.
  double gravity_sigma = 0.0;
  double free_gravity = 0.0;  ///< Gravity's length before it was imposed, m/s^2.
  double rotation_rms = 0.0;  ///< Of the gyroscope against vision, in standard deviations.
  double motion_rms = 0.0;    ///< Of the accelerometer against vision, likewise.

  /// Why it must not be used yet, for messages; empty where it may.
  std::string refused;
};

/// A start in motion (or without) from frames' poses, `world_from_body` in any one frame, and the
/// samples between. Intervals that the samples do not cover, or where they are further apart than
/// 0.1 s, are passed over. Throws Error for options out of range and frames that are not in order
/// of time; what the data do not bear out is `refused`. `noise` is that in use, not that of a data
/// sheet: with motors running EuRoC's accelerometer needs twenty times its density for the
/// covariance to be true. The cost grows with the cube of the number of frames: tens are meant.
InertialStart StartInMotion(const Trajectory& frames, const std::vector<ImuSample>& samples,
                            const ImuNoise& noise, const InitialisationOptions& options);

}  // namespace gluevo::vo
