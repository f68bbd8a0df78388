#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/frame_result.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/pipeline/odometry.h"

namespace gluevo::apps {

/// How a run's inertial unit fared.
struct ImuRecord {
  std::filesystem::path file;
  std::optional<vo::InertialBegin> begin;
  std::string why_waiting;
  double gyroscope_noise_factor = 1.0;
  double accelerometer_noise_factor = 1.0;
  std::string clock_fault;  ///< ClockWatch::Fault().
};

/// Whether the data set's inertial unit is used, as --imu asks (DatasetArguments::imu). What a user
/// should know of it goes into the data set's notes and warnings; one that is used becomes the
/// rig's body where it is not. Throws Error where it is asked for and there is none, or it cannot
/// be used.
bool ChooseImu(const std::string& asked, const std::string& solver, vo::Dataset& dataset);

/// Nothing where the odometry uses no unit.
std::optional<ImuRecord> MakeImuRecord(const vo::Dataset& dataset, const vo::Odometry& odometry);

/// What stands under "imu" in metrics.json.
nlohmann::ordered_json ImuJson(const ImuRecord& record, const std::vector<vo::FrameResult>& frames);

/// What turns the world of the poses so that z is up, by the newest estimate of gravity; nothing
/// where there is none.
std::optional<Eigen::Quaterniond> LevelFromWorld(const std::vector<vo::FrameResult>& frames);

/// A pose for every reading between two frames of one segment that were located while the unit
/// counted (PosesAtReadings), in the world of the frames' poses.
vo::Trajectory ImuRateTrajectory(const vo::ImuData& imu,
                                 const std::vector<vo::FrameResult>& frames);

}  // namespace gluevo::apps
