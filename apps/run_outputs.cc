#include "run_outputs.h"

#include <exception>
#include <map>
#include <optional>
#include <ostream>
#include <string>
#include <system_error>
#include <vector>

#include "command_line/message.h"
#include "covariance_file.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "gluevo/vo/mapping/map.h"
#include "gluevo/vo/mapping/map_culling.h"
#include "gluevo/vo/mapping/place_map.h"
#include "gluevo/vo/pipeline/loop_config.h"
#include "report/run_report.h"
#include "run_imu.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

// The world that poses are written in.
struct World {
  std::optional<vo::Rigid3> new_from_old_world;  // Nothing where it is that of the estimates.
  std::string name;
};

World WorldOf(const std::vector<vo::FrameResult>& frames) {
  if (const auto level_from_world = LevelFromWorld(frames)) {
    return {vo::Rigid3{*level_from_world, Eigen::Vector3d::Zero()},
            "whose z is up by the inertial unit and whose origin and yaw are those of the first "
            "pose"};
  }
  return {std::nullopt, "which is its frame at the first pose"};
}

// The map's is kept as it is: other runs know it.
World WorldOfPlaces(const RunRecords& records) {
  if (records.loops->has_loaded_map()) {
    return {std::nullopt, "which is that of the loaded map where its places were found"};
  }
  return WorldOf(records.metrics.frames());
}

vo::Trajectory Turned(const vo::Rigid3& new_from_old_world, vo::Trajectory trajectory) {
  for (vo::StampedPose& pose : trajectory) {
    pose.world_from_body = new_from_old_world * pose.world_from_body;
  }
  return trajectory;
}

void WriteMap(const RunPlaces& places, const RunRecords& records) {
  vo::Map map = records.map->Build();
  if (const auto level_from_world = LevelFromWorld(records.metrics.frames())) {
    vo::TurnWorld(*level_from_world, map);
  }
  vo::WritePly(places.map, map);
  vo::WriteColmap(ColmapFolder(places), map);
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
  const auto write = [&](const std::string& name, const vo::Trajectory& trajectory,
                         const World& world) {
    vo::WriteTrajectory(
        places.folder / (name + format.extension),
        world.new_from_old_world ? Turned(*world.new_from_old_world, trajectory) : trajectory,
        format.format, "pose of the " + dataset.rig.body_frame + " in the world, " + world.name);
  };
  const World world = WorldOf(records.metrics.frames());
  write("trajectory", records.trajectory, world);
  write("keyframes", records.keyframes, world);
  if (places.has_imu_rate) {
    write("imu_rate", ImuRateTrajectory(*dataset.imu, records.metrics.frames()), world);
  }
  if (context.loops) {
    write("trajectory_optimized", context.loops->optimized, WorldOfPlaces(records));
  } else {
    // An earlier run's would be taken for this one's.
    fs::remove(places.folder / (std::string("trajectory_optimized") + format.extension));
  }
}

void WriteReport(const RunPlaces& places, const vo::Dataset& dataset, const std::string& name,
                 const RunRecords& records, const RunMetrics::Context& context) {
  RunReport report = records.metrics.Report(context);
  report.dataset = name;
  report.rig = dataset.rig;
  report.groundtruth = dataset.groundtruth;
  if (context.loops) {
    report.loops = {context.loops->optimized, context.loops->attempts};
  }
  report.strip = records.strip.frames();
  WriteRunReport(places.folder / "report.html", report);
}

// The first failure; empty where there is none.
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
  if (!places.saved_map.empty()) {
    attempt([&] {
      WritePlaces(places, records, context.loops->keyframe_poses, vo::FeaturesOf(context.weights));
    });
  }
  if (records.map) {
    attempt([&] { WriteMap(places, records); });
  }
  return failure;
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

fs::path ColmapFolder(const RunPlaces& places) { return places.map / "colmap"; }

// The names of what a run puts into its folders may be taken.
void CheckPlaces(const RunPlaces& places) {
  for (const auto& files : {OutputFiles(places), MapFiles(places)}) {
    for (const fs::path& file : files) {
      nn::CheckPlaceForFile(file);
    }
  }
  if (!places.saved_map.empty()) {
    nn::CheckPlaceForFile(places.saved_map);
  }
  std::error_code code;
  const fs::path models = ColmapFolder(places);
  if (!places.map.empty() && fs::exists(models, code) && !fs::is_directory(models, code)) {
    throw Error(models.string() + ": is a file; expected a folder for output");
  }
}

// Localised frames are in the world of trajectory_optimized.
void WritePlaces(const RunPlaces& places, const RunRecords& records,
                 const std::vector<vo::Rigid3>& keyframe_poses, const vo::MapFeatures& features) {
  vo::PlaceMap map = vo::MakePlaceMap(records.loops->closer(), keyframe_poses, features);
  if (const auto new_from_old_world = WorldOfPlaces(records).new_from_old_world) {
    for (vo::LoopKeyframe& keyframe : map.keyframes) {
      keyframe.world_from_body = *new_from_old_world * keyframe.world_from_body;
    }
    for (vo::Rigid3& map_from_body : map.map_from_body) {
      map_from_body = *new_from_old_world * map_from_body;
    }
  }
  vo::WritePlaceMap(places.saved_map, vo::CullPlaceMap(std::move(map), places.culling));
}

void FinishRun(const RunPlaces& places, const vo::Dataset& dataset, const std::string& name,
               RunRecords& records, const RunMetrics::Context& context, std::ostream& out) {
  const std::string failure = WriteOutputs(places, dataset, name, records, context);
  out << records.metrics.Summary(context) << "results: " << OneLine(places.folder.string()) << '\n';
  if (const std::string& first = context.failure.empty() ? failure : context.failure;
      !first.empty()) {
    throw Error(first);
  }
}

}  // namespace gluevo::apps
