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
#include "gluevo/nn/error.h"
#include "gluevo/nn/isa.h"
#include "gluevo/vo/dataset.h"
#include "gluevo/vo/evaluation.h"
#include "gluevo/vo/klt_frontend.h"
#include "gluevo/vo/learned_frontend.h"
#include "gluevo/vo/map.h"
#include "gluevo/vo/network_matcher.h"
#include "gluevo/vo/odometry.h"
#include "gluevo/vo/trajectory.h"
#include "network_options.h"
#include "progress.h"
#include "report/run_report.h"
#include "report/strip.h"
#include "run_metrics.h"
#include "yaml_config.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct RunArguments {
  fs::path dataset;
  fs::path output;
  fs::path config;
  std::string method = "superglue";
  std::string matcher = "superglue";
  std::string format;
  fs::path calibration;
  fs::path groundtruth;
  fs::path map;
  std::string trajectory_format = "tum";
  vo::DatasetOptions frames;
  NetworkOptions networks;
  nn::SuperPointOptions superpoint = {.keypoint_threshold = 0.005F, .max_keypoints = 500};
  vo::LearnedFrontEndOptions learned;
  vo::KltOptions klt;
  vo::OdometryOptions odometry;
};

void AddRunOptions(CLI::App& command, RunArguments& arguments) {
  command.add_option("DATASET", arguments.dataset, "Folder of the data set")->required();
  command.add_option("-o,--output", arguments.output, "Folder for the results")->required();
  command
      .add_option("--method", arguments.method,
                  "Front end: superglue (SuperPoint and SuperGlue) or klt (corners and optical "
                  "flow)")
      ->check(CLI::IsMember({"superglue", "klt"}))
      ->capture_default_str();
  command
      .add_option("--matcher", arguments.matcher,
                  "What matches SuperPoint's keypoints: superglue, or nn for mutual nearest "
                  "neighbours")
      ->check(CLI::IsMember({"superglue", "nn"}))
      ->capture_default_str();
  command.add_option("--config", arguments.config,
                     "YAML file with values for any of these options; the command line goes first");
  command
      .add_option("--format", arguments.format,
                  "Kind of the data set: euroc, kitti, kitti-raw or plain; default: recognised")
      ->check(CLI::IsMember({"euroc", "kitti", "kitti-raw", "plain"}));
  command.add_option("--calibration", arguments.calibration,
                     "Calibration of a plain data set: Kalibr camchain or OpenCV yaml");
  command.add_option("--groundtruth", arguments.groundtruth,
                     "Ground truth (TUM, EuRoC csv or KITTI); default: the data set's own");
  command.add_option("--start", arguments.frames.start, "First frame")->capture_default_str();
  command.add_option("--count", arguments.frames.count, "Number of frames; default: all");
  command.add_option("--stride", arguments.frames.stride, "Take every so many-th frame")
      ->capture_default_str();
  command
      .add_option("--trajectory-format", arguments.trajectory_format,
                  "Format of the trajectories: tum, euroc or kitti")
      ->check(CLI::IsMember({"tum", "euroc", "kitti"}))
      ->capture_default_str();
  command.add_option("--map", arguments.map,
                     "Folder for the sparse map: points.ply, keyframes.ply and colmap/SEGMENT "
                     "(COLMAP's text model)");
  AddNetworkOptions(command, arguments.networks);

  const std::string tuning = "Tuning";
  AddSuperPointOptions(command, arguments.superpoint);
  command
      .add_option("--tracking-threshold", arguments.learned.tracking_threshold,
                  "Confidence of a match from the previous left image")
      ->capture_default_str()
      ->group(tuning);
  command
      .add_option("--stereo-threshold", arguments.learned.stereo_threshold,
                  "Confidence of a match from left to right")
      ->capture_default_str()
      ->group(tuning);
  command
      .add_option("--max-epipolar-error", arguments.learned.max_epipolar_error_px,
                  "Largest distance of a stereo match from its epipolar line, pixels")
      ->capture_default_str()
      ->group(tuning);
  command
      .add_option("--min-distance", arguments.learned.min_distance_px,
                  "Smallest distance between observed points, pixels")
      ->capture_default_str()
      ->group(tuning);
  command.add_option("--klt-corners", arguments.klt.max_corners, "Corners of the klt method")
      ->capture_default_str()
      ->group(tuning);
  command.add_option("--window", arguments.odometry.window.size, "Frames of the sliding window")
      ->capture_default_str()
      ->group(tuning);
  command.footer(
      "Writes DIR/trajectory.tum (a pose for every frame), DIR/keyframes.tum, "
      "DIR/metrics.json and DIR/report.html.\nExample:\n  gluevo run data/V1_01_easy -o "
      "results/V1_01");
}

vo::DatasetOptions MakeDatasetOptions(const RunArguments& arguments) {
  vo::DatasetOptions options = arguments.frames;
  if (arguments.format == "euroc") {
    options.format = vo::DatasetFormat::kEuroc;
  } else if (arguments.format == "kitti") {
    options.format = vo::DatasetFormat::kKittiOdometry;
  } else if (arguments.format == "kitti-raw") {
    options.format = vo::DatasetFormat::kKittiRaw;
  } else if (arguments.format == "plain") {
    options.format = vo::DatasetFormat::kPlain;
  }
  if (!arguments.calibration.empty()) {
    options.calibration = arguments.calibration;
  }
  if (!arguments.groundtruth.empty()) {
    options.groundtruth = arguments.groundtruth;
  }
  return options;
}

std::unique_ptr<vo::FrontEnd> MakeFrontEnd(const RunArguments& arguments, const vo::StereoRig& rig,
                                           const Networks& networks, nn::ThreadPool& pool) {
  if (arguments.method == "klt") {
    return std::make_unique<vo::KltFrontEnd>(rig, arguments.klt);
  }
  constexpr int kSinkhornIterations = 100;
  std::unique_ptr<vo::Matcher> matcher =
      networks.superglue != nullptr
          ? vo::MakeSuperGlueMatcher(networks.superglue, kSinkhornIterations, pool)
          : vo::MakeNearestNeighborMatcher();
  return std::make_unique<vo::LearnedFrontEnd>(
      rig, vo::MakeSuperPointExtractor(networks.superpoint, arguments.superpoint, pool),
      std::move(matcher), vo::MakeNearestNeighborMatcher(), arguments.learned);
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

void Run(const RunArguments& arguments, const CLI::App& command) {
  const vo::Dataset dataset = vo::OpenDataset(arguments.dataset, MakeDatasetOptions(arguments));
  nn::ThreadPool pool(arguments.networks.threads);
  vo::OdometryOptions odometry_options = arguments.odometry;
  if (arguments.method == "klt") {
    // The baseline trusts its calibration, as VINS-Fusion does: the errors of optical flow between
    // the two cameras are not zero on average, and would pass for an error of the calibration.
    odometry_options.window.right_turn_sigma = 0.0;
  }
  cv::setNumThreads(pool.size());
  Networks networks;
  if (arguments.method != "klt") {
    networks = LoadNetworks(arguments.networks, arguments.matcher == "superglue");
  }
  vo::Odometry odometry(dataset.rig, MakeFrontEnd(arguments, dataset.rig, networks, pool),
                        odometry_options);

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
      const vo::StereoFrame frame = dataset.Read(i);
      metrics.FrameIsRead();
      const vo::FrameResult result = odometry.Process(frame);
      metrics.FrameIsDone(result);
      strip.Add(frame, result);
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
  std::string evaluation_failure;
  if (dataset.groundtruth) {
    try {
      evaluation = vo::Evaluate(trajectory, *dataset.groundtruth, {});
    } catch (const Error& error) {
      evaluation_failure = error.what();
    }
  }
  const RunMetrics::Context context = {.method = arguments.method,
                                       .threads = pool.size(),
                                       .superpoint = networks.superpoint_record,
                                       .superglue = networks.superglue_record,
                                       .options = OptionValues(command),
                                       .evaluation = evaluation,
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
  std::cout << metrics.Summary(evaluation) << "results: " << arguments.output.string() << '\n';
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
    Run(*arguments, *command);
  });
}

}  // namespace gluevo::apps
