#include "run_outputs.h"

#include <exception>
#include <map>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "covariance_file.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "gluevo/vo/mapping/map.h"
#include "report/run_report.h"
#include "run_imu.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

std::string TrajectoryHeader(const vo::StereoRig& rig, bool is_level) {
  return "pose of the " + rig.body_frame + " in the world, " +
         (is_level ? "whose z is up by the inertial unit and whose origin and yaw are those of the "
                     "first pose"
                   : "which is its frame at the first pose");
}

vo::Trajectory Turned(const Eigen::Quaterniond& level_from_world, vo::Trajectory trajectory) {
  const vo::Rigid3 new_from_old_world = {level_from_world, Eigen::Vector3d::Zero()};
  for (vo::StampedPose& pose : trajectory) {
    pose.world_from_body = new_from_old_world * pose.world_from_body;
  }
  return trajectory;
}

void WriteMap(const fs::path& directory, const RunRecords& records) {
  vo::Map map = records.map->Build();
  if (const auto level_from_world = LevelFromWorld(records.metrics.frames())) {
    vo::TurnWorld(*level_from_world, map);
  }
  vo::WritePly(directory, map);
  vo::WriteColmap(directory / "colmap", map);
}

// As a trajectory is written.
struct Format {
  vo::TrajectoryFormat format;
  const char* extension;
};

const Format& FormatOf(const RunPlaces& places) {
  static const std::map<std::string, Format> formats = {
      {"tum", {vo::TrajectoryFormat::kTum, ".tum"}},
      {"euroc", {vo::TrajectoryFormat::kEuroc, ".csv"}},
      {"kitti", {vo::TrajectoryFormat::kKitti, ".txt"}}};
  return formats.at(places.trajectory_format);
}

void WriteTrajectories(const RunPlaces& places, const vo::Dataset& dataset,
                       const RunRecords& records, const RunMetrics::Context& context) {
  const Format& format = FormatOf(places);
  const auto level_from_world = LevelFromWorld(records.metrics.frames());
  const std::string header = TrajectoryHeader(dataset.rig, level_from_world.has_value());
  std::vector<std::pair<std::string, const vo::Trajectory*>> trajectories = {
      {"trajectory", &records.trajectory}, {"keyframes", &records.keyframes}};
  if (context.loops) {
    trajectories.emplace_back("trajectory_optimized", &context.loops->optimized);
  }
  vo::Trajectory imu_rate;
  if (places.has_imu_rate) {
    imu_rate = ImuRateTrajectory(*dataset.imu, records.metrics.frames());
    trajectories.emplace_back("imu_rate", &imu_rate);
  }
  for (const auto& [name, trajectory] : trajectories) {
    vo::WriteTrajectory(places.folder / (name + format.extension),
                        level_from_world ? Turned(*level_from_world, *trajectory) : *trajectory,
                        format.format, header);
  }
}

void WriteReport(const RunPlaces& places, const vo::Dataset& dataset, const std::string& name,
                 const RunRecords& records, const RunMetrics::Context& context) {
  RunReport report = records.metrics.Report(context);
  report.dataset = name;
  report.rig = dataset.rig;
  report.groundtruth = dataset.groundtruth;
  report.strip = records.strip.frames();
  WriteRunReport(places.folder / "report.html", report);
}

}  // namespace

std::vector<fs::path> OutputFiles(const RunPlaces& places) {
  const std::string extension = FormatOf(places).extension;
  std::vector<fs::path> files = {places.folder / ("trajectory" + extension),
                                 places.folder / ("keyframes" + extension),
                                 places.folder / "covariance.csv", places.folder / "metrics.json",
                                 places.folder / "report.html"};
  if (places.has_imu_rate) {
    files.push_back(places.folder / ("imu_rate" + extension));
  }
  if (places.has_loops) {
    files.push_back(places.folder / ("trajectory_optimized" + extension));
  }
  return files;
}

std::vector<fs::path> MapFiles(const RunPlaces& places) {
  if (places.map.empty()) {
    return {};
  }
  return {places.map / "points.ply", places.map / "keyframes.ply"};
}

// The names of what a run puts into its folders may be taken.
void CheckPlaces(const RunPlaces& places) {
  for (const auto& files : {OutputFiles(places), MapFiles(places)}) {
    for (const fs::path& file : files) {
      nn::CheckPlaceForFile(file);
    }
  }
  std::error_code code;
  const fs::path models = places.map / "colmap";
  if (!places.map.empty() && fs::exists(models, code) && !fs::is_directory(models, code)) {
    throw Error(models.string() + ": is a file; expected a folder for output");
  }
}

std::string WriteOutputs(const RunPlaces& places, const vo::Dataset& dataset,
                         const std::string& name, RunRecords& records,
                         const RunMetrics::Context& context) {
  std::string failure;
  const auto attempt = [&](const auto& write) {
    try {
      write();
    } catch (const std::exception& error) {
      failure = failure.empty() ? error.what() : failure;
    }
  };
  attempt([&] { WriteTrajectories(places, dataset, records, context); });
  attempt([&] {
    WriteCovariances(places.folder / "covariance.csv", records.metrics.frames(),
                     dataset.rig.body_frame);
  });
  attempt([&] { records.metrics.Write(places.folder / "metrics.json", context); });
  attempt([&] { WriteReport(places, dataset, name, records, context); });
  if (records.matches) {
    attempt([&] { records.matches->Finish(); });
  }
  if (records.map) {
    attempt([&] { WriteMap(places.map, records); });
  }
  return failure;
}

}  // namespace gluevo::apps
