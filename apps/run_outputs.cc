#include "run_outputs.h"

#include <exception>
#include <map>
#include <system_error>
#include <utility>

#include "covariance_file.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "gluevo/vo/mapping/map.h"
#include "gluevo/vo/mapping/place_map.h"
#include "gluevo/vo/pipeline/loop_config.h"
#include "report/run_report.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

std::string TrajectoryHeader(const vo::StereoRig& rig) {
  return "pose of the " + rig.body_frame + " in the world, which is its frame at the first pose";
}

void WriteMap(const fs::path& directory, const vo::MapRecorder& recorder) {
  const vo::Map map = recorder.Build();
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
                       const RunRecords& records) {
  const Format& format = FormatOf(places);
  const std::string header = TrajectoryHeader(dataset.rig);
  for (const auto& [name, trajectory] :
       {std::pair{"trajectory", &records.trajectory}, std::pair{"keyframes", &records.keyframes}}) {
    vo::WriteTrajectory(places.folder / (std::string(name) + format.extension), *trajectory,
                        format.format, header);
  }
}

void WriteOptimized(const RunPlaces& places, const vo::Dataset& dataset,
                    const vo::Trajectory& trajectory) {
  const Format& format = FormatOf(places);
  vo::WriteTrajectory(places.folder / (std::string("trajectory_optimized") + format.extension),
                      trajectory, format.format, TrajectoryHeader(dataset.rig));
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

}  // namespace

std::vector<fs::path> OutputFiles(const RunPlaces& places) {
  const std::string extension = FormatOf(places).extension;
  std::vector<fs::path> files = {places.folder / ("trajectory" + extension),
                                 places.folder / ("keyframes" + extension),
                                 places.folder / "covariance.csv", places.folder / "metrics.json",
                                 places.folder / "report.html"};
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
  if (!places.saved_map.empty()) {
    nn::CheckPlaceForFile(places.saved_map);
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
  attempt([&] { WriteTrajectories(places, dataset, records); });
  if (context.loops) {
    attempt([&] { WriteOptimized(places, dataset, context.loops->optimized); });
  }
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
      vo::WritePlaceMap(places.saved_map, records.loops->Map(vo::FeaturesOf(context.weights)));
    });
  }
  if (records.map) {
    attempt([&] { WriteMap(places.map, *records.map); });
  }
  return failure;
}

}  // namespace gluevo::apps
