// gluevo run: stereo odometry over a data set.

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <string>
#include <vector>

#include "commands.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/frontend/match_store.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/io/output_directory.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "gluevo/vo/mapping/map.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "options/dataset_options.h"
#include "options/estimator_options.h"
#include "options/frontend_options.h"
#include "options/preset_options.h"
#include "options/yaml_config.h"
#include "progress.h"
#include "report/run_report.h"
#include "report/strip.h"
#include "run_metrics.h"
#include "run_replay.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct RunArguments {
  fs::path dataset;
  fs::path output;
  fs::path config_file;
  std::string preset;
  fs::path map;
  std::string trajectory_format = "tum";
  DatasetArguments frames;
  fs::path save_matches;
  fs::path replay;
  vo::OdometryConfig config;
};

void AddRunOptions(CLI::App& command, RunArguments& arguments) {
  command.add_option("DATASET", arguments.dataset, "Folder of the data set")->required();
  command.add_option("-o,--output", arguments.output, "Folder for the results")->required();
  command.add_option("--config", arguments.config_file,
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
  AddPresetOption(command, arguments.preset);
  AddFrontEndOptions(command, arguments.config);
  AddEstimatorOptions(command, arguments.config.odometry);
  command.footer(
      "Writes DIR/trajectory.tum (a pose for every frame), DIR/keyframes.tum, "
      "DIR/metrics.json and DIR/report.html.\nExample:\n  gluevo run data/V1_01_easy -o "
      "results/V1_01");
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

// Everything that a run needs and that can fail, before its first frame.
struct Setup {
  vo::Dataset dataset;
  std::string method;
  OptionOrigins origins;
  vo::Networks networks;
  std::unique_ptr<vo::FrontEnd> frontend;
  bool reads_images = true;
};

Setup SetUp(RunArguments& arguments, CLI::App& command, const std::map<std::string, bool>& given,
            nn::ThreadPool& pool) {
  Setup setup;
  setup.method = arguments.config.frontend.method;
  std::optional<vo::MatchStoreReader> store;
  if (!arguments.replay.empty()) {
    store.emplace(arguments.replay);
    setup.method = ReplayedMethod(command, *store);
    SelectReplayedFrames(command, *store, arguments.frames.start, arguments.frames.count,
                         arguments.frames.stride);
  }
  setup.dataset = vo::OpenDataset(arguments.dataset, MakeDatasetOptions(arguments.frames));
  PrintNotes(setup.dataset);
  setup.origins =
      ApplyPreset(command, arguments.preset, setup.dataset.format, given, arguments.config);
  setup.reads_images = !store || !arguments.map.empty();
  if (store) {
    setup.networks.superpoint_record = ReplayedWeights(*store, "superpoint");
    setup.networks.superglue_record = ReplayedWeights(*store, "superglue");
    setup.frontend = std::make_unique<vo::ReplayFrontEnd>(*std::move(store), setup.dataset.rig,
                                                          TimesOf(setup.dataset));
  } else {
    setup.networks = vo::LoadFrontEndNetworks(arguments.config.frontend);
    setup.frontend =
        vo::MakeFrontEnd(arguments.config.frontend, setup.dataset.rig, setup.networks, pool);
  }
  return setup;
}

// What gathers over the frames.
struct Records {
  RunMetrics metrics;
  StripRecorder strip;
  std::optional<vo::MatchStoreWriter> matches;
  std::optional<vo::MapRecorder> map;
  vo::Trajectory trajectory;
  vo::Trajectory keyframes;
};

void ProcessFrames(const Setup& setup, vo::Odometry& odometry, Records& records) {
  const vo::Dataset& dataset = setup.dataset;
  Progress progress("frame", dataset.entries.size());
  for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
    records.metrics.StartFrame();
    const vo::StereoFrame frame =
        setup.reads_images ? dataset.Read(i) : vo::StereoFrame{dataset.entries[i].timestamp_ns, {}};
    records.metrics.FrameIsRead();
    const vo::FrameResult result = odometry.Process(frame);
    records.metrics.FrameIsDone(result);
    if (records.matches) {
      records.matches->Add(result.tracked_frame);
    }
    if (setup.reads_images) {
      records.strip.Add(result, [&] { return frame; });
    }
    if (records.map) {
      records.map->Add(frame, ImageNames(dataset, i), result, odometry.rig(), odometry.MapPoints());
    }
    records.trajectory.push_back({result.timestamp_ns, result.world_from_body});
    if (result.is_keyframe) {
      records.keyframes.push_back(records.trajectory.back());
    }
    progress.Update(i + 1, std::to_string(result.inliers) + " inliers, segment " +
                               std::to_string(result.segment));
  }
}

void WriteTrajectories(const RunArguments& arguments, const Setup& setup, const Records& records) {
  struct Format {
    vo::TrajectoryFormat format;
    const char* extension;
  };
  static const std::map<std::string, Format> formats = {
      {"tum", {vo::TrajectoryFormat::kTum, ".tum"}},
      {"euroc", {vo::TrajectoryFormat::kEuroc, ".csv"}},
      {"kitti", {vo::TrajectoryFormat::kKitti, ".txt"}}};
  const Format& format = formats.at(arguments.trajectory_format);
  const std::string header = TrajectoryHeader(setup.dataset.rig);
  for (const auto& [name, trajectory] :
       {std::pair{"trajectory", &records.trajectory}, std::pair{"keyframes", &records.keyframes}}) {
    vo::WriteTrajectory(arguments.output / (std::string(name) + format.extension), *trajectory,
                        format.format, header);
  }
}

void AddEvaluations(const Setup& setup, const Records& records, RunMetrics::Context& context) {
  if (!setup.dataset.groundtruth) {
    return;
  }
  const vo::Trajectory& groundtruth = *setup.dataset.groundtruth;
  try {
    context.evaluation = vo::Evaluate(records.trajectory, groundtruth, {});
    context.segmented_evaluation = vo::EvaluateSegments(
        records.trajectory, records.metrics.SegmentOfFrames(), groundtruth, {});
  } catch (const Error& error) {
    context.evaluation_failure = error.what();
  }
}

void Run(RunArguments& arguments, CLI::App& command, const std::map<std::string, bool>& given) {
  nn::ThreadPool pool(arguments.config.threads);
  cv::setNumThreads(pool.size());
  Setup setup = SetUp(arguments, command, given, pool);
  const vo::OutputDirectory output(arguments.output);
  std::optional<vo::OutputDirectory> map_output;
  if (!arguments.map.empty()) {
    map_output.emplace(arguments.map);
  }
  vo::Odometry odometry(setup.dataset.rig, std::move(setup.frontend), arguments.config.odometry);
  Records records{.strip = StripRecorder(setup.dataset.entries.size())};
  if (!arguments.save_matches.empty()) {
    records.matches.emplace(arguments.save_matches, setup.dataset.rig,
                            MakeRunRecord(command, setup.method, setup.networks));
  }
  if (!arguments.map.empty()) {
    records.map.emplace(setup.dataset.rig.cameras, vo::MapOptions());
  }

  ProcessFrames(setup, odometry, records);

  if (records.matches) {
    records.matches->Finish();
  }
  WriteTrajectories(arguments, setup, records);
  RunMetrics::Context context = {.method = setup.method,
                                 .threads = pool.size(),
                                 .superpoint = setup.networks.superpoint_record,
                                 .superglue = setup.networks.superglue_record,
                                 .options = OptionValues(command),
                                 .origins = setup.origins,
                                 .dataset_warnings = setup.dataset.warnings,
                                 .images_left_out = setup.dataset.images_left_out};
  AddEvaluations(setup, records, context);
  records.metrics.Write(arguments.output / "metrics.json", context);
  RunReport report = records.metrics.Report(context);
  report.dataset = arguments.dataset.string();
  report.rig = setup.dataset.rig;
  report.groundtruth = setup.dataset.groundtruth;
  report.strip = records.strip.frames();
  WriteRunReport(arguments.output / "report.html", report);
  if (records.map) {
    WriteMap(arguments.map, *records.map);
  }
  std::cout << records.metrics.Summary(context) << "results: " << arguments.output.string() << '\n';
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "run", "Stereo odometry over a data set: images in, trajectory and figures out");
  const auto arguments = std::make_shared<RunArguments>();
  AddRunOptions(*command, *arguments);
  command->callback([arguments, command] {
    const std::map<std::string, bool> given = OptionsGiven(*command);
    if (!arguments->config_file.empty()) {
      ApplyYamlConfig(*command, arguments->config_file);
    }
    Run(*arguments, *command, given);
  });
}

}  // namespace gluevo::apps
