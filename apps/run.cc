// gluevo run: stereo odometry over a data set.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <string>
#include <vector>

#include "command_line/message.h"
#include "command_line/value_checks.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "earlier_results.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/frontend/match_store.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/io/output_directory.h"
#include "gluevo/vo/mapping/map.h"
#include "gluevo/vo/pipeline/loop_config.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "interruption.h"
#include "options/estimator_options.h"
#include "options/frontend_options.h"
#include "options/loop_options.h"
#include "options/network_options.h"
#include "options/preset_options.h"
#include "options/yaml_config.h"
#include "run_evaluation.h"
#include "run_frames.h"
#include "run_imu.h"
#include "run_metrics.h"
#include "run_outputs.h"
#include "run_replay.h"
#include "run_setup.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

void AddRunOptions(CLI::App& command, RunArguments& arguments) {
  command.add_option("DATASET", arguments.dataset, "Folder of the data set")->required();
  command.add_option("-o,--output", arguments.places.folder, "Folder for the results")
      ->option_text("TEXT REQUIRED");
  command.add_option("--config", arguments.config_file,
                     "YAML file with values for any of these options; the command line goes first");
  AddDatasetOptions(command, arguments.frames);
  command
      .add_option("--trajectory-format", arguments.places.trajectory_format,
                  "Format of the trajectories: tum, euroc or kitti")
      ->check(OneOf({"tum", "euroc", "kitti"}))
      ->capture_default_str();
  command.add_option("--map", arguments.places.map,
                     "Folder for the sparse map: points.ply, keyframes.ply and colmap/SEGMENT "
                     "(COLMAP's text model)");
  CLI::Option* const save = command.add_option("--save-matches", arguments.save_matches,
                                               "HDF5 file to write the matches of all frames to");
  command
      .add_option(
          "--replay", arguments.replay,
          "Take the matches from such a file: reads no images and runs no networks, but for "
          "--loops; the frames are the stored run's where no option chooses others")
      ->excludes(save);
  command.add_flag("--imu-rate", arguments.places.has_imu_rate,
                   "Write imu_rate, too: a pose for every reading of the inertial unit");
  command.add_flag(
      "--estimate-time-offset", arguments.config.odometry.inertial.estimate_time_offset,
      "Estimate how far the inertial unit's clock is ahead of the images', within some "
      "10 ms (imu.time_offset_s in metrics.json)");
  command.add_flag("--strict", arguments.is_strict,
                   "End at a frame that cannot be read, in place of leaving it out; what came "
                   "before it is kept");
  AddPresetOption(command, arguments.preset);
  AddFrontEndOptions(command, arguments.config);
  AddEstimatorOptions(command, arguments.config.odometry);
  AddLoopOptions(command, arguments.loops, arguments.places.saved_map, arguments.places.culling);
  command.footer(
      "Writes DIR/trajectory.tum (a pose for every frame), DIR/keyframes.tum, "
      "DIR/covariance.csv, DIR/metrics.json and DIR/report.html.\nExample:\n  gluevo run "
      "data/V1_01_easy -o "
      "results/V1_01");
}

void CheckOutputs(const RunArguments& arguments) {
  std::vector<fs::path> outputs = OutputFiles(arguments.places);
  outputs.push_back(arguments.save_matches);
  outputs.push_back(arguments.places.saved_map);
  std::vector<fs::path> inputs = arguments.frames.calibration;
  for (const fs::path& input :
       {arguments.dataset, arguments.config_file, arguments.replay, arguments.frames.groundtruth,
        arguments.loops.codebook, arguments.loops.load_map,
        MakeDatasetOptions(arguments.frames).imu.value_or(""), arguments.frames.imu_calibration}) {
    inputs.push_back(input);
  }
  for (const fs::path& input : WeightsInputs(arguments.config.frontend.networks)) {
    inputs.push_back(input);
  }
  CheckOutputsAreNoInputs(outputs, inputs);
  CheckReplacesOnlyResults(arguments.places, arguments.save_matches, arguments.dataset);
}

RunRecords MakeRecords(const RunArguments& arguments, const CLI::App& command, RunSetup& setup) {
  RunRecords records{.strip = StripRecorder(setup.dataset.entries.size()),
                     .diagnosis = vo::Diagnosis(setup.dataset.rig, setup.method != "klt")};
  if (!arguments.save_matches.empty()) {
    records.matches.emplace(arguments.save_matches, setup.dataset.rig,
                            MakeRunRecord(command, setup.method, setup.networks));
  }
  if (!arguments.places.map.empty()) {
    CheckNamesForMap(setup.dataset);
    records.map.emplace(setup.dataset.rig.cameras, vo::MapOptions());
  }
  records.loops = std::move(setup.loops);
  return records;
}

void Run(RunArguments& arguments, CLI::App& command, const std::map<std::string, bool>& given) {
  const Interruption interruption;
  TurnOnForMaps(command, arguments.loops, arguments.places.saved_map);
  arguments.places.has_loops = arguments.loops.is_on;
  CheckOutputs(arguments);
  nn::ThreadPool pool(arguments.config.threads);
  cv::setNumThreads(pool.size());
  RunSetup setup = SetUp(arguments, command, given, pool);
  const vo::OutputDirectory output(arguments.places.folder);
  std::optional<vo::OutputDirectory> map_output;
  if (!arguments.places.map.empty()) {
    map_output.emplace(arguments.places.map);
  }
  CheckPlaces(arguments.places);
  vo::Odometry odometry(setup.dataset.rig, std::move(setup.frontend), arguments.config.odometry);
  if (setup.uses_imu) {
    odometry.UseImu(setup.dataset.imu->noise);
    odometry.AddImu(setup.dataset.imu->samples);
  }
  RunRecords records = MakeRecords(arguments, command, setup);

  const EarlyEnd end =
      ProcessFrames({setup.dataset, setup.reads_images, arguments.is_strict}, odometry, records);

  const auto throw_where_interrupted = [&] {
    if (end.signal != 0) {
      throw Interrupted{end.signal};
    }
  };
  if (records.trajectory.empty()) {
    throw_where_interrupted();
    throw Error(!end.failure.empty() ? end.failure : records.metrics.WhyNothingWasRead());
  }
  RunMetrics::Context context = {.method = setup.method,
                                 .features = setup.features,
                                 .matcher = setup.matcher,
                                 .threads = pool.size(),
                                 .weights = setup.networks.records,
                                 .options = OptionValues(command),
                                 .origins = setup.origins,
                                 .dataset_warnings = setup.dataset.warnings,
                                 .images_left_out = setup.dataset.images_left_out,
                                 .frames_asked = setup.dataset.entries.size(),
                                 .is_interrupted = end.signal != 0,
                                 .failure = end.failure,
                                 .causes = records.diagnosis.Causes(),
                                 .imu = MakeImuRecord(setup.dataset, odometry)};
  AddEvaluations(setup.dataset, records, context);
  if (records.loops) {
    context.loops =
        CloseLoops(*records.loops, arguments.loops.has_final_adjustment, setup.dataset.groundtruth);
  }
  const std::string failure =
      WriteOutputs(arguments.places, setup.dataset, arguments.dataset.string(), records, context);
  std::cout << records.metrics.Summary(context)
            << "results: " << OneLine(arguments.places.folder.string()) << '\n';
  if (const std::string& first = end.failure.empty() ? failure : end.failure; !first.empty()) {
    throw Error(first);
  }
  throw_where_interrupted();
  records.metrics.CheckThatSomethingWasTracked(context);
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
    if (arguments->places.folder.empty()) {
      throw CLI::RequiredError("--output");  // Which the file may give.
    }
    Run(*arguments, *command, given);
  });
}

}  // namespace gluevo::apps
