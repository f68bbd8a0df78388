// gluevo run: stereo odometry over a data set.

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <string>
#include <vector>

#include "commands.h"
#include "dataset_options.h"
#include "estimator_options.h"
#include "frontend_options.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/isa.h"
#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/frontend/match_store.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "gluevo/vo/mapping/map.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "option_defaults.h"
#include "progress.h"
#include "report/run_report.h"
#include "report/strip.h"
#include "run_metrics.h"
#include "run_replay.h"
#include "yaml_config.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct RunArguments {
  fs::path dataset;
  fs::path output;
  fs::path config;
  fs::path map;
  std::string trajectory_format = "tum";
  DatasetArguments frames;
  fs::path save_matches;
  fs::path replay;
  FrontEndArguments frontend;
  EstimatorOptions estimator;
};

void AddRunOptions(CLI::App& command, RunArguments& arguments) {
  command.add_option("DATASET", arguments.dataset, "Folder of the data set")->required();
  command.add_option("-o,--output", arguments.output, "Folder for the results")->required();
  command.add_option("--config", arguments.config,
                     "YAML file with values for any of these options; the command line goes first");
  AddDatasetOptions(command, arguments.frames);
  command
      .add_option("--trajectory-format", arguments.trajectory_format,
                  "Format of the trajectories: tum, euroc or kitti")
      ->check(CLI::IsMember({"tum", "euroc", "kitti"}))
      ->capture_default_str();
  command.add_option("--map", arguments.map,
                     "Folder for the sparse map: points.ply, keyframes.ply and colmap/SEGMENT "
                     "(COLMAP's text model)");
  CLI::Option* const save = command.add_option("--save-matches", arguments.save_matches,
                                               "HDF5 file to write the matches of all frames to");
  command
      .add_option("--replay", arguments.replay,
                  "Take the matches from such a file: reads no images and runs no networks; the "
                  "frames are the stored run's where no option chooses others")
      ->excludes(save);
  AddFrontEndOptions(command, arguments.frontend);
  AddEstimatorOptions(command, arguments.estimator);
  command.footer(
      "Writes DIR/trajectory.tum (a pose for every frame), DIR/keyframes.tum, "
      "DIR/metrics.json and DIR/report.html.\nExample:\n  gluevo run data/V1_01_easy -o "
      "results/V1_01");
}

// VINS-Fusion's constants for driving, where neither command line nor configuration says more.
void ApplyDrivingPreset(CLI::App& command) {
  SetUnlessGiven(command, "--klt-corners", "200");
  SetUnlessGiven(command, "--keyframe-parallax", "15");
}

std::string TrajectoryHeader(const vo::StereoRig& rig) {
  return "pose of the " + rig.body_frame + " in the world, which is its frame at the first pose";
}

// As COLMAP finds the images when it is told the data set's folder.
std::array<std::string, 2> ImageNames(const vo::Dataset& dataset, std::size_t index) {
  const auto name = [&](const fs::path& path) {
    return path.lexically_proximate(dataset.root).generic_string();
  };
  const auto& images = dataset.entries[index].images;
  return {name(images[0]), name(images[1])};
}

void WriteMap(const fs::path& directory, const vo::MapRecorder& recorder) {
  const vo::Map map = recorder.Build();
  vo::WritePly(directory, map);
  vo::WriteColmap(directory / "colmap", map);
}

std::vector<int64_t> TimesOf(const vo::Dataset& dataset) {
  std::vector<int64_t> timestamps_ns;
  for (const vo::Dataset::Entry& entry : dataset.entries) {
    timestamps_ns.push_back(entry.timestamp_ns);
  }
  return timestamps_ns;
}

void Run(RunArguments& arguments, CLI::App& command) {
  std::string method = arguments.frontend.method;
  std::optional<vo::MatchStoreReader> store;
  if (!arguments.replay.empty()) {
    store.emplace(arguments.replay);
    method = ReplayedMethod(command, *store);
    SelectReplayedFrames(command, *store, arguments.frames.start, arguments.frames.count,
                         arguments.frames.stride);
  }
  const vo::Dataset dataset =
      vo::OpenDataset(arguments.dataset, MakeDatasetOptions(arguments.frames));
  if (dataset.format == vo::DatasetFormat::kKittiOdometry ||
      dataset.format == vo::DatasetFormat::kKittiRaw) {
    ApplyDrivingPreset(command);
  }
  nn::ThreadPool pool(arguments.frontend.networks.threads);
  cv::setNumThreads(pool.size());
  Networks networks;
  std::unique_ptr<vo::FrontEnd> frontend;
  const bool is_replay = store.has_value();
  if (is_replay) {
    networks.superpoint_record = ReplayedWeights(*store, "superpoint");
    networks.superglue_record = ReplayedWeights(*store, "superglue");
    frontend =
        std::make_unique<vo::ReplayFrontEnd>(*std::move(store), dataset.rig, TimesOf(dataset));
  } else {
    networks = LoadFrontEndNetworks(arguments.frontend);
    frontend = MakeFrontEnd(arguments.frontend, dataset.rig, networks, pool);
  }
  vo::Odometry odometry(dataset.rig, std::move(frontend),
                        ResolveEstimatorOptions(arguments.estimator));
  std::optional<vo::MatchStoreWriter> saved;
  if (!arguments.save_matches.empty()) {
    saved.emplace(arguments.save_matches, dataset.rig, MakeRunRecord(command, method, networks));
  }

  RunMetrics metrics;
  StripRecorder strip(dataset.entries.size());
  std::optional<vo::MapRecorder> map;
  if (!arguments.map.empty()) {
    map.emplace(dataset.rig.cameras, vo::MapOptions());
  }
  vo::Trajectory trajectory;
  vo::Trajectory keyframes;
  {
    Progress progress("frame", dataset.entries.size());
    for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
      metrics.StartFrame();
      const bool reads_images = !is_replay || map;
      const vo::StereoFrame frame =
          reads_images ? dataset.Read(i) : vo::StereoFrame{dataset.entries[i].timestamp_ns, {}};
      metrics.FrameIsRead();
      const vo::FrameResult result = odometry.Process(frame);
      metrics.FrameIsDone(result);
      if (saved) {
        saved->Add(result.tracked_frame);
      }
      if (reads_images) {
        strip.Add(result, [&] { return frame; });
      }
      if (map) {
        map->Add(frame, ImageNames(dataset, i), result, odometry.rig(), odometry.MapPoints());
      }
      trajectory.push_back({result.timestamp_ns, result.world_from_body});
      if (result.is_keyframe) {
        keyframes.push_back(trajectory.back());
      }
      progress.Update(i + 1, std::to_string(result.inliers) + " inliers, segment " +
                                 std::to_string(result.segment));
    }
  }
  if (saved) {
    saved->Finish();
  }

  fs::create_directories(arguments.output);
  const vo::TrajectoryFormat format =
      arguments.trajectory_format == "tum"     ? vo::TrajectoryFormat::kTum
      : arguments.trajectory_format == "euroc" ? vo::TrajectoryFormat::kEuroc
                                               : vo::TrajectoryFormat::kKitti;
  const std::string extension = arguments.trajectory_format == "tum"     ? ".tum"
                                : arguments.trajectory_format == "euroc" ? ".csv"
                                                                         : ".txt";
  vo::WriteTrajectory(arguments.output / ("trajectory" + extension), trajectory, format,
                      TrajectoryHeader(dataset.rig));
  vo::WriteTrajectory(arguments.output / ("keyframes" + extension), keyframes, format,
                      TrajectoryHeader(dataset.rig));

  std::optional<vo::Evaluation> evaluation;
  std::optional<vo::SegmentedEvaluation> segmented_evaluation;
  std::string evaluation_failure;
  if (dataset.groundtruth) {
    try {
      evaluation = vo::Evaluate(trajectory, *dataset.groundtruth, {});
      segmented_evaluation =
          vo::EvaluateSegments(trajectory, metrics.SegmentOfFrames(), *dataset.groundtruth, {});
    } catch (const Error& error) {
      evaluation_failure = error.what();
    }
  }
  const RunMetrics::Context context = {.method = method,
                                       .threads = pool.size(),
                                       .superpoint = networks.superpoint_record,
                                       .superglue = networks.superglue_record,
                                       .options = OptionValues(command),
                                       .evaluation = evaluation,
                                       .segmented_evaluation = segmented_evaluation,
                                       .evaluation_failure = evaluation_failure};
  metrics.Write(arguments.output / "metrics.json", context);
  RunReport report = metrics.Report(context);
  report.dataset = arguments.dataset.string();
  report.rig = dataset.rig;
  report.groundtruth = dataset.groundtruth;
  report.strip = strip.frames();
  WriteRunReport(arguments.output / "report.html", report);
  if (map) {
    WriteMap(arguments.map, *map);
  }
  std::cout << metrics.Summary(context) << "results: " << arguments.output.string() << '\n';
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "run", "Stereo odometry over a data set: images in, trajectory and figures out");
  const auto arguments = std::make_shared<RunArguments>();
  AddRunOptions(*command, *arguments);
  command->callback([arguments, command] {
    if (!arguments->config.empty()) {
      ApplyYamlConfig(*command, arguments->config);
    }
    ApplyMethodDefaults(*command, arguments->frontend);
    Run(*arguments, *command);
  });
}

}  // namespace gluevo::apps
