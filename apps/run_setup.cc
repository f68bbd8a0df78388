#include "run_setup.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/frontend/match_store.h"
#include "gluevo/vo/frontend/network_memo.h"
#include "run_imu.h"
#include "run_replay.h"

namespace gluevo::apps {
namespace {

std::vector<int64_t> TimesOf(const vo::Dataset& dataset) {
  std::vector<int64_t> timestamps_ns;
  for (const vo::Dataset::Entry& entry : dataset.entries) {
    timestamps_ns.push_back(entry.timestamp_ns);
  }
  return timestamps_ns;
}

void MakeFrontEndAndLoops(const RunArguments& arguments, nn::ThreadPool& pool, RunSetup& setup) {
  const vo::FrontEndConfig& config = arguments.config.frontend;
  std::shared_ptr<vo::FeatureExtractor> shared;
  if (arguments.loops.is_on) {
    setup.networks = vo::LoadNetworksWithLoops(config);
    shared = std::make_shared<vo::ExtractorMemo>(
        vo::MakeFrontEndExtractor(config, setup.networks, pool));
    setup.loops.emplace(
        vo::MakeLoopRecorder(arguments.loops, setup.dataset.rig, setup.networks, shared, pool));
  } else {
    setup.networks = vo::LoadFrontEndNetworks(config);
  }
  setup.frontend = vo::MakeFrontEnd(config, setup.dataset.rig, setup.networks, pool, shared);
}

// The networks are those of the command line: klt's stored runs have none.
void MakeLoopsOfReplay(const RunArguments& arguments, const vo::MatchStoreReader& store,
                       nn::ThreadPool& pool, RunSetup& setup) {
  const vo::FrontEndConfig& config = arguments.config.frontend;
  const vo::Networks networks = vo::LoadNetworksWithLoops(config);
  AddReplayedWeights(networks.records, store.path(), setup.networks.records);
  setup.loops.emplace(vo::MakeLoopRecorder(arguments.loops, setup.dataset.rig, networks,
                                           vo::MakeFrontEndExtractor(config, networks, pool),
                                           pool));
}

}  // namespace

RunSetup SetUp(RunArguments& arguments, CLI::App& command, const std::map<std::string, bool>& given,
               nn::ThreadPool& pool) {
  RunSetup setup;
  if (arguments.loops.has_final_adjustment && !arguments.loops.is_on) {
    throw Error("--final-adjustment on is of what loops keep: expected --loops on");
  }
  setup.method = arguments.config.frontend.method;
  std::optional<vo::MatchStoreReader> store;
  if (!arguments.replay.empty()) {
    store.emplace(arguments.replay);
    setup.method = ReplayedMethod(command, *store);
    SelectReplayedFrames(command, *store, arguments.frames.start, arguments.frames.count,
                         arguments.frames.stride);
  }
  setup.dataset = vo::OpenDataset(arguments.dataset, MakeDatasetOptions(arguments.frames));
  setup.uses_imu =
      ChooseImu(arguments.frames.imu, arguments.config.odometry.window.solver, setup.dataset);
  if (arguments.places.has_imu_rate && !setup.uses_imu) {
    throw Error(arguments.dataset.string() +
                ": no inertial unit is used, which --imu-rate needs (see --imu)");
  }
  if (arguments.config.odometry.inertial.estimate_time_offset && !setup.uses_imu) {
    throw Error(setup.dataset.root.string() +
                ": no inertial unit is used, which --estimate-time-offset needs (see --imu)");
  }
  PrintNotes(setup.dataset);
  if (store) {
    LeaveOutReplayed(*store, setup.dataset);
  }
  setup.origins =
      ApplyPreset(command, arguments.preset, setup.dataset.format, given, arguments.config);
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
    setup.features = setup.method == "klt" ? "" : arguments.config.frontend.features;
    setup.matcher = vo::MatcherOf(arguments.config.frontend);
    MakeFrontEndAndLoops(arguments, pool, setup);
  }
  return setup;
}

}  // namespace gluevo::apps
