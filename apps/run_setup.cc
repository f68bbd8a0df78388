#include "run_setup.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "command_line/message.h"
#include "command_line/value_checks.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/isa.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/vo/frontend/network_memo.h"
#include "gluevo/vo/pipeline/loop_thread.h"
#include "options/estimator_options.h"
#include "options/frontend_options.h"
#include "options/loop_options.h"
#include "options/network_options.h"
#include "options/yaml_config.h"
#include "run_evaluation.h"
#include "run_imu.h"

namespace gluevo::apps {

namespace fs = std::filesystem;

void AddRunArguments(CLI::App& command, RunArguments& arguments) {
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
  command.add_flag("--imu-rate", arguments.places.has_imu_rate,
                   "Write imu_rate, too: a pose for every reading of the inertial unit");
  command.add_flag(
      "--estimate-time-offset", arguments.config.odometry.inertial.estimate_time_offset,
      "Estimate how far the inertial unit's clock is ahead of the images', within some "
      "10 ms (imu.time_offset_s in metrics.json)");
  AddPresetOption(command, arguments.preset);
  AddFrontEndOptions(command, arguments.config);
  command.add_option("--cpus", arguments.processors,
                     "Processors to run on, as in 0,2-3; default: all. Without --threads there is "
                     "a thread for each of them");
  AddEstimatorOptions(command, arguments.config.odometry);
  AddLoopOptions(command, arguments.loops, arguments.places.saved_map, arguments.places.culling);
}

namespace {

// What can be told without a look at any file: what is typed wrong is said before what is missing.
void CheckUsage(const RunArguments& arguments) {
  arguments.config.Validate();
  arguments.loops.options.Validate();
  const std::string& solver = arguments.config.odometry.window.solver;
  const std::string why = arguments.frames.imu == "off" ? "--imu off"
                          : solver != "gluevo"          ? "--solver " + solver
                                                        : "";
  const auto refuse_without_imu = [&](bool is_asked, const std::string& option) {
    if (is_asked && !why.empty()) {
      throw OptionError(why + " uses no inertial unit, expected no " + option);
    }
  };
  refuse_without_imu(arguments.places.has_imu_rate, "--imu-rate");
  refuse_without_imu(arguments.config.odometry.inertial.estimate_time_offset,
                     "--estimate-time-offset");
}

}  // namespace

std::map<std::string, bool> TakeConfigFile(CLI::App& command, const RunArguments& arguments) {
  std::map<std::string, bool> given = OptionsGiven(command);
  if (!arguments.config_file.empty()) {
    ApplyYamlConfig(command, arguments.config_file);
  }
  if (arguments.places.folder.empty()) {
    throw CLI::RequiredError("--output");  // Which the file may give.
  }
  CheckUsage(arguments);
  return given;
}

std::vector<fs::path> OutputsOf(const RunArguments& arguments) {
  std::vector<fs::path> outputs = OutputFiles(arguments.places);
  if (!arguments.places.map.empty()) {
    for (const fs::path& file : MapFiles(arguments.places)) {
      outputs.push_back(file);
    }
    outputs.push_back(ColmapFolder(arguments.places));
  }
  outputs.push_back(arguments.places.saved_map);
  return outputs;
}

std::vector<fs::path> InputsOf(const RunArguments& arguments) {
  std::vector<fs::path> inputs = arguments.frames.calibration;
  for (const fs::path& input :
       {arguments.config_file, arguments.frames.groundtruth, arguments.loops.codebook,
        arguments.loops.load_map, MakeDatasetOptions(arguments.frames).imu.value_or(""),
        arguments.frames.imu_calibration}) {
    inputs.push_back(input);
  }
  for (const fs::path& input : WeightsInputs(arguments.config.frontend.networks)) {
    inputs.push_back(input);
  }
  return inputs;
}

void ApplyPresetAndWarn(CLI::App& command, const std::map<std::string, bool>& given, bool is_replay,
                        RunArguments& arguments, RunSetup& setup) {
  setup.origins =
      ApplyPreset(command, arguments.preset, setup.dataset.format, given, arguments.config);
  const vo::FrontEndConfig& frontend = arguments.config.frontend;
  for (const std::string& warning : UnusedFrontEndOptions(
           command, is_replay ? setup.method : frontend.method, is_replay, frontend)) {
    PrintMessage("gluevo: warning", warning);
    setup.dataset.warnings.push_back(warning);
  }
}

void SetUpImu(const RunArguments& arguments, RunSetup& setup) {
  setup.uses_imu =
      ChooseImu(arguments.frames.imu, arguments.config.odometry.window.solver, setup.dataset);
  const auto needs_one = [&](bool is_asked, const std::string& option) {
    if (is_asked && !setup.uses_imu) {
      throw Error(setup.dataset.root.string() + ": no inertial unit is used, which " + option +
                  " needs (see --imu)");
    }
  };
  needs_one(arguments.places.has_imu_rate, "--imu-rate");
  needs_one(arguments.config.odometry.inertial.estimate_time_offset, "--estimate-time-offset");
}

void SetUpLoops(const RunArguments& arguments, const vo::Networks& networks, int threads,
                RunSetup& setup) {
  // Where processors are few, one is tracking's alone.
  setup.loop_threads = vo::MakeBackgroundPool(std::max(1, threads / 2));
  setup.loops.emplace(vo::MakeLoopRecorder(
      arguments.loops, setup.dataset.rig, networks,
      vo::MakeFrontEndExtractor(arguments.config.frontend, networks, *setup.loop_threads),
      *setup.loop_threads));
}

namespace {

// A name that is mistyped is no reason to go on without what it was given for.
bool NamesWeightsThatAreNot(const vo::NetworkFiles& files) {
  const std::vector<fs::path> named = WeightsInputs(files);
  return std::any_of(named.begin(), named.end(), [](const fs::path& file) {
    std::error_code code;
    return !file.empty() && !fs::exists(file, code);
  });
}

}  // namespace

void SetUpFrontEnd(CLI::App& command, nn::ThreadPool& pool, RunArguments& arguments,
                   RunSetup& setup) {
  nn::ChooseIsa();  // What cannot be had is said now: klt's records name it, too, at the end.
  const vo::FrontEndConfig& config = arguments.config.frontend;
  setup.method = config.method;
  setup.features = setup.method == "klt" ? "" : config.features;
  setup.matcher = vo::MatcherOf(config);
  if (arguments.loops.is_on) {
    try {
      setup.networks = vo::LoadNetworksWithLoops(config);
      SetUpLoops(arguments, setup.networks, pool.size(), setup);
    } catch (const Error& error) {
      if (arguments.needs_loops || NamesWeightsThatAreNot(config.networks)) {
        throw;
      }
      setup.networks = vo::LoadFrontEndNetworks(config);  // What fails here is not only loops'.
      const std::string warning = std::string("loops are off: ") + error.what();
      PrintMessage("gluevo: note", warning);
      setup.dataset.warnings.push_back(warning);
      SetLoops(command, false, arguments.loops);
    }
  } else {
    setup.networks = vo::LoadFrontEndNetworks(config);
  }
  if (arguments.loops.is_on && setup.method != "klt") {
    setup.extracted = std::make_shared<vo::ExtractorMemo>(
        vo::MakeFrontEndExtractor(config, setup.networks, pool));
  }
  setup.frontend =
      vo::MakeFrontEnd(config, setup.dataset.rig, setup.networks, pool, setup.extracted);
}

int KernelThreads(const RunArguments& arguments, int threads) {
  return arguments.config.frontend.method == "klt" ? std::max(1, threads - 1) : threads;
}

vo::Odometry MakeOdometry(const RunArguments& arguments, RunSetup& setup) {
  vo::Odometry odometry(setup.dataset.rig, std::move(setup.frontend), arguments.config.odometry);
  if (setup.uses_imu) {
    odometry.UseImu(setup.dataset.imu->noise);
  }
  return odometry;
}

RunMetrics::Context MakeContext(const CLI::App& command, const RunArguments& arguments,
                                const RunSetup& setup, const RunRecords& records,
                                const vo::Odometry& odometry, const EarlyEnd& end, int threads) {
  RunMetrics::Context context = {.method = setup.method,
                                 .features = setup.features,
                                 .matcher = setup.matcher,
                                 .threads = threads,
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
  return context;
}

}  // namespace gluevo::apps
