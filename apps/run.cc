// gluevo run: stereo odometry over a data set.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <string>
#include <vector>

#include "commands.h"
#include "dataset_options.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/isa.h"
#include "gluevo/vo/dataset.h"
#include "gluevo/vo/evaluation.h"
#include "gluevo/vo/klt_frontend.h"
#include "gluevo/vo/learned_frontend.h"
#include "gluevo/vo/network_matcher.h"
#include "gluevo/vo/odometry.h"
#include "gluevo/vo/trajectory.h"
#include "network_options.h"
#include "progress.h"
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
  std::string trajectory_format = "tum";
  DatasetArguments frames;
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
  AddDatasetOptions(command, arguments.frames);
  command
      .add_option("--trajectory-format", arguments.trajectory_format,
                  "Format of the trajectories: tum, euroc or kitti")
      ->check(CLI::IsMember({"tum", "euroc", "kitti"}))
      ->capture_default_str();
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
      "Writes DIR/trajectory.tum (a pose for every frame), DIR/keyframes.tum and "
      "DIR/metrics.json.\nExample:\n  gluevo run data/V1_01_easy -o results/V1_01");
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

void Run(const RunArguments& arguments, const CLI::App& command) {
  const vo::Dataset dataset =
      vo::OpenDataset(arguments.dataset, MakeDatasetOptions(arguments.frames));
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
  metrics.Write(arguments.output / "metrics.json", {.method = arguments.method,
                                                    .threads = pool.size(),
                                                    .superpoint = networks.superpoint_record,
                                                    .superglue = networks.superglue_record,
                                                    .options = OptionValues(command),
                                                    .evaluation = evaluation,
                                                    .segmented_evaluation = segmented_evaluation,
                                                    .evaluation_failure = evaluation_failure});
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
