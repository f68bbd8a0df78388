#include "run_imu.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/median.h"
#include "gluevo/vo/inertial/gravity.h"
#include "gluevo/vo/inertial/poses_at_readings.h"
#include "newest_estimate.h"

namespace gluevo::apps {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const Eigen::Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

double MedianRms(const std::vector<vo::FrameResult>& frames, double vo::InertialEstimate::*rms) {
  std::vector<double> values;
  values.reserve(frames.size());
  for (const vo::FrameResult& frame : frames) {
    if (frame.inertial) {
      values.push_back((*frame.inertial).*rms);
    }
  }
  return vo::Median(std::move(values));
}

}  // namespace

bool ChooseImu(const std::string& asked, const std::string& solver, vo::Dataset& dataset) {
  if (asked == "off" || (asked == "auto" && solver != "gluevo")) {
    return false;
  }
  if (!dataset.imu) {
    if (asked == "on") {
      throw Error(dataset.root.string() +
                  ": has no inertial unit, which --imu on asks for; --imu FILE names its readings");
    }
    return false;
  }
  if (!dataset.imu->refused.empty()) {
    if (asked != "auto") {
      throw Error(dataset.imu->refused);
    }
    dataset.warnings.push_back("the inertial unit is not used: " + dataset.imu->refused);
    return false;
  }
  const vo::ImuData& imu = *dataset.imu;
  dataset.notes.insert(dataset.notes.end(), imu.notes.begin(), imu.notes.end());
  dataset.warnings.insert(dataset.warnings.end(), imu.warnings.begin(), imu.warnings.end());
  if (!imu.imu_in_body.isZero()) {
    vo::PutBodyAtImu(dataset);
  }
  return true;
}

std::optional<ImuRecord> MakeImuRecord(const vo::Dataset& dataset, const vo::Odometry& odometry) {
  const vo::InertialNavigation* const inertial = odometry.inertial();
  if (inertial == nullptr) {
    return std::nullopt;
  }
  return ImuRecord{dataset.imu->path,
                   inertial->begin(),
                   inertial->why_waiting(),
                   inertial->gyroscope_noise_factor(),
                   inertial->accelerometer_noise_factor(),
                   inertial->clock().Fault()};
}

Json ImuJson(const ImuRecord& record, const std::vector<vo::FrameResult>& frames) {
  Json json;
  json["file"] = record.file.string();
  json["initialised_at_s"] = nullptr;
  if (record.begin) {
    json["initialised_at_s"] =
        1e-9 * static_cast<double>(record.begin->timestamp_ns - frames.front().timestamp_ns);
    json["initialised"] = record.begin->is_at_rest ? "at rest" : "in motion";
    json["initial_gravity_sigma_deg"] = record.begin->gravity_sigma / vo::kDegree;
  } else {
    json["waits_for"] = record.why_waiting;
  }
  json["frames_bridged"] = Json::array();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].is_bridged) {
      json["frames_bridged"].push_back(i);
    }
  }
  if (const vo::InertialEstimate* const newest =
          NewestEstimate(frames, &vo::FrameResult::inertial)) {
    json["gravity"] = ToJson(newest->gravity_in_world);
    json["gravity_sigma_deg"] = newest->gravity_sigma / vo::kDegree;
    json["gyroscope_bias"] = ToJson(newest->bias.gyroscope);
    json["gyroscope_bias_sigma"] = newest->gyroscope_bias_sigma;
    json["accelerometer_bias"] = ToJson(newest->bias.accelerometer);
    json["accelerometer_bias_sigma"] = newest->accelerometer_bias_sigma;
    if (newest->time_offset_s) {
      json["time_offset_s"] = *newest->time_offset_s;
      json["time_offset_sigma_s"] = newest->time_offset_sigma_s;
    }
    json["residual"] = {
        {"gyroscope", MedianRms(frames, &vo::InertialEstimate::gyroscope_rms)},
        {"accelerometer", MedianRms(frames, &vo::InertialEstimate::accelerometer_rms)}};
  }
  json["noise_factor"] = {{"gyroscope", record.gyroscope_noise_factor},
                          {"accelerometer", record.accelerometer_noise_factor}};
  return json;
}

vo::Trajectory ImuRateTrajectory(const vo::ImuData& imu,
                                 const std::vector<vo::FrameResult>& frames) {
  vo::ImuReadings readings(imu.noise);
  readings.Add(imu.samples);
  if (const vo::InertialEstimate* const newest = NewestEstimate(frames, &vo::FrameResult::inertial);
      newest && newest->time_offset_s) {
    readings.set_time_offset_s(*newest->time_offset_s);
  }
  vo::Trajectory trajectory;
  const vo::FrameResult* before = nullptr;
  for (const vo::FrameResult& frame : frames) {
    if (!frame.inertial) {
      continue;
    }
    if (before != nullptr && before->segment == frame.segment) {
      const vo::InertialEstimate& inertial = *before->inertial;
      const vo::Trajectory between = vo::PosesAtReadings(
          {before->timestamp_ns,
           {before->world_from_body, inertial.velocity_in_world, inertial.bias}},
          {frame.timestamp_ns, frame.world_from_body}, inertial.gravity_in_world, readings);
      trajectory.insert(trajectory.end(), between.begin(), between.end());
    }
    before = &frame;
  }
  return trajectory;
}

std::optional<Eigen::Quaterniond> LevelFromWorld(const std::vector<vo::FrameResult>& frames) {
  const vo::InertialEstimate* const newest = NewestEstimate(frames, &vo::FrameResult::inertial);
  return newest == nullptr ? std::nullopt
                           : std::optional(vo::LevelFromWorld(newest->gravity_in_world));
}

}  // namespace gluevo::apps
