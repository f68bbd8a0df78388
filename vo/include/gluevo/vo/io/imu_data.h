#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo {

/// What an inertial unit beside the cameras read.
struct ImuData {
  std::filesystem::path path;  ///< The file or folder, for messages.
  /// In order of time, without two of one time, on the clock of the images (what the calibration
  /// says of the clocks is taken off), along the axes of the rig's body; rad/s and m/s^2. Empty
  /// where they cannot be read.
  std::vector<ImuSample> samples;
  /// Where the unit is in the rig's body, metres; zero where it is the body. What it feels is felt
  /// there.
  Eigen::Vector3d imu_in_body = Eigen::Vector3d::Zero();
  ImuNoise noise;
  /// What the calibration says of the clocks: t_imu = t_image + time_shift_s.
  double time_shift_s = 0.0;
  double rate_hz = 0.0;  ///< By the median step; 0 of less than two samples.
  /// Where an axis was seen to end, rad/s and m/s^2; infinite where it was not.
  double largest_rate = std::numeric_limits<double>::infinity();
  double largest_force = std::numeric_limits<double>::infinity();
  /// Why the unit cannot be used, one line that names the file; empty where it can.
  std::string refused;
  std::vector<std::string> notes;     ///< How it was understood, a sentence each.
  std::vector<std::string> warnings;  ///< What is wrong and survived, a sentence each.
};

/// How the unit is mounted and what its noise is, in a calibration of its own.
struct ImuCalibration {
  std::optional<ImuNoise> noise;  ///< Nothing where the file has none of it.
  Rigid3 body_from_imu;           ///< T_BS or the inverse of T_i_b; identity without.
  std::vector<std::string> warnings;
};

/// Reads EuRoC's sensor.yaml of an inertial unit, Kalibr's imu.yaml (alone or under imu0),
/// VINS-Fusion's acc_n, acc_w, gyr_n and gyr_w, or ORB-SLAM3's IMU.NoiseGyro and so on. Throws
/// Error naming the file that is none of them, a figure that is missing beside others, and one that
/// is no density.
ImuCalibration ReadImuCalibration(const std::filesystem::path& path);

/// The inertial unit of a folder in EuRoC's layout or a drive of KITTI raw, without its images: on
/// its own clock, along its own axes. Nothing where there is none. Never throws for what is in the
/// files: that is `refused`.
std::optional<ImuData> FindImu(const std::filesystem::path& root);

}  // namespace gluevo::vo
