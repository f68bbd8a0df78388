// gluevo run: stereo odometry over a data set.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command_line/message.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "earlier_results.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/frontend/match_store.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/io/output_directory.h"
#include "gluevo/vo/mapping/map.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "interruption.h"
#include "options/loop_options.h"
#include "options/preset_options.h"
#include "processors.h"
#include "run_frames.h"
#include "run_metrics.h"
#include "run_outputs.h"
#include "run_replay.h"
#include "run_setup.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

// What run is told beyond what live is told, too.
struct OfflineArguments : RunArguments {
  fs::path dataset;
  fs::path save_matches;
  fs::path replay;
  bool is_strict = false;
};

void AddRunOptions(CLI::App& command, OfflineArguments& arguments) {
  command.add_option("DATASET", arguments.dataset, "Folder of the data set")->required();
  arguments.loops.is_on = true;
  AddRunArguments(command, arguments);
  command.add_option("--map", arguments.places.map,
                     "Folder for the sparse map: points.ply, keyframes.ply and colmap/SEGMENT "
                     "(COLMAP's text model)");
  CLI::Option* const save = command.add_option("--save-matches", arguments.save_matches,
                                               "HDF5 file to write the matches of all frames to");
  command
      .add_option(
          "--replay", arguments.replay,
          "Take the matches from such a file: reads no images and runs no networks, but for "
          "--loops on, which is not the default then; the frames are the stored run's where no "
          "option chooses others")
      ->excludes(save);
  command.add_flag("--strict", arguments.is_strict,
                   "End at a frame that cannot be read, in place of leaving it out; what came "
                   "before it is kept");
  command.footer(
      "Writes DIR/trajectory.tum (a pose for every frame), DIR/keyframes.tum, "
      "DIR/covariance.csv, DIR/metrics.json, DIR/report.html and, with loops, "
      "DIR/trajectory_optimized.tum.\nExample:\n  gluevo run "
      "data/V1_01_easy -o "
      "results/V1_01");
}

void CheckOutputs(const OfflineArguments& arguments) {
  std::vector<fs::path> outputs = OutputsOf(arguments);
  outputs.push_back(arguments.save_matches);
  std::vector<fs::path> inputs = InputsOf(arguments);
  inputs.push_back(arguments.dataset);
  inputs.push_back(arguments.replay);
  CheckOutputsAreDistinct(outputs);
  CheckOutputsAreNoInputs(outputs, inputs);
  CheckReplacesOnlyResults(arguments.places, arguments.save_matches, arguments.dataset);
}

std::vector<int64_t> TimesOf(const vo::Dataset& dataset) {
  std::vector<int64_t> timestamps_ns;
  for (const vo::Dataset::Entry& entry : dataset.entries) {
    timestamps_ns.push_back(entry.timestamp_ns);
  }
  return timestamps_ns;
}

// The networks are those of the command line: klt's stored runs have none.
void MakeLoopsOfReplay(const RunArguments& arguments, const vo::MatchStoreReader& store,
                       const nn::ThreadPool& pool, RunSetup& setup) {
  const vo::Networks networks = vo::LoadNetworksWithLoops(arguments.config.frontend);
  AddReplayedWeights(networks.records, store.path(), setup.networks.records);
  SetUpLoops(arguments, networks, pool.size(), setup);
}

RunSetup SetUp(OfflineArguments& arguments, CLI::App& command,
               const std::map<std::string, bool>& given, nn::ThreadPool& pool) {
  RunSetup setup;
  std::optional<vo::MatchStoreReader> store;
  if (!arguments.replay.empty()) {
    store.emplace(arguments.replay);
    setup.method = ReplayedMethod(command, *store);
    SelectReplayedFrames(command, *store, arguments.frames.start, arguments.frames.count,
                         arguments.frames.stride);
  }
  setup.dataset = vo::OpenDataset(arguments.dataset, MakeDatasetOptions(arguments.frames));
  SetUpImu(arguments, setup);
  PrintNotes(setup.dataset);
  if (store) {
    LeaveOutReplayed(*store, setup.dataset);
  }
  ApplyPresetAndWarn(command, given, store.has_value(), arguments, setup);
  setup.reads_images = !store || !arguments.places.map.empty() || arguments.loops.is_on;
  if (store) {
    setup.networks.records = ReplayedWeights(*store);
    if (arguments.loops.is_on) {
      MakeLoopsOfReplay(arguments, *store, pool, setup);
    }
    setup.features = ReplayedFeatures(*store);
    setup.matcher = ReplayedMatcher(*store);
    setup.frontend = std::make_unique<vo::ReplayFrontEnd>(*std::move(store), setup.dataset.rig,
                                                          TimesOf(setup.dataset));
  } else {
    SetUpFrontEnd(command, pool, arguments, setup);
  }
  return setup;
}

RunRecords MakeRecords(const OfflineArguments& arguments, const CLI::App& command,
                       RunSetup& setup) {
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
  records.extracted = setup.extracted;
  return records;
}

void Run(OfflineArguments& arguments, CLI::App& command, const std::map<std::string, bool>& given) {
  const Interruption interruption;
  // A replay's point is to need no images and no networks.
  arguments.needs_loops =
      SettleLoops(command, arguments.replay.empty(), arguments.places.saved_map, arguments.loops);
  arguments.places.has_loops = arguments.loops.is_on;
  CheckOutputs(arguments);
  UseProcessors(arguments.processors);
  const int threads = ThreadsOf(arguments.config.threads);
  nn::ThreadPool pool(threads);
  UseKernelThreads(KernelThreads(arguments, threads));
  RunSetup setup = SetUp(arguments, command, given, pool);
  const vo::OutputDirectory output(arguments.places.folder);
  std::optional<vo::OutputDirectory> map_output;
  std::error_code is_new;
  if (!arguments.places.map.empty() &&
      !fs::equivalent(arguments.places.map, arguments.places.folder, is_new)) {
    map_output.emplace(arguments.places.map);
  }
  CheckPlaces(arguments.places);
  vo::Odometry odometry = MakeOdometry(arguments, setup);
  if (setup.uses_imu) {
    odometry.AddImu(setup.dataset.imu->samples);
  }
  RunRecords records = MakeRecords(arguments, command, setup);

  const EarlyEnd end = ProcessFrames(
      {setup.dataset, setup.reads_images, arguments.is_strict, threads > 1}, odometry, records);

  const auto throw_where_interrupted = [&] {
    if (end.signal != 0) {
      throw Interrupted{end.signal};
    }
  };
  if (records.trajectory.empty()) {
    throw_where_interrupted();
    throw Error(!end.failure.empty() ? end.failure : records.metrics.WhyNothingWasRead());
  }
  const RunMetrics::Context context =
      MakeContext(command, arguments, setup, records, odometry, end, threads);
  FinishRun(arguments.places, setup.dataset, arguments.dataset.string(), records, context,
            std::cout);
  throw_where_interrupted();
  records.metrics.CheckThatSomethingWasTracked(context);
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "run", "Stereo odometry over a data set: images in, trajectory and figures out");
  const auto arguments = std::make_shared<OfflineArguments>();
  AddRunOptions(*command, *arguments);
  command->callback([arguments, command] {
    const std::map<std::string, bool> given = TakeConfigFile(*command, *arguments);
    Run(*arguments, *command, given);
  });
}

}  // namespace gluevo::apps
