#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command_line.h"
#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/frontend/network_memo.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/mapping/loop_recorder.h"
#include "gluevo/vo/pipeline/loop_config.h"
#include "gluevo/vo/pipeline/networks.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "options/dataset_options.h"
#include "options/preset_options.h"
#include "run_frames.h"
#include "run_metrics.h"
#include "run_outputs.h"

namespace gluevo::apps {

/// What `gluevo run` and `gluevo live` are told alike.
struct RunArguments {
  RunPlaces places;
  std::filesystem::path config_file;
  std::string preset;
  DatasetArguments frames;
  std::string processors;  ///< As UseProcessors takes it.
  vo::OdometryConfig config;
  vo::LoopConfig loops;
  /// Whether something asks for them: a run that cannot have them fails.
  bool needs_loops = false;
};

/// Their options.
void AddRunArguments(CLI::App& command, RunArguments& arguments);

/// Once the command line is read: what the file of --config says counts where that says nothing.
/// Returns what OptionsGiven says of the command line alone. Throws where neither names an output,
/// and OptionError for values that do not go with each other.
std::map<std::string, bool> TakeConfigFile(CLI::App& command, const RunArguments& arguments);

/// Files that the arguments name: to write, and to read. (Those of one command alone apart.)
std::vector<std::filesystem::path> OutputsOf(const RunArguments& arguments);
std::vector<std::filesystem::path> InputsOf(const RunArguments& arguments);

/// Everything that a run needs and that can fail, before its first frame.
struct RunSetup {
  vo::Dataset dataset;
  std::string method;
  std::string features;  ///< Empty where the method has none, as the next.
  std::string matcher;
  OptionOrigins origins;
  vo::Networks networks;
  std::unique_ptr<vo::FrontEnd> frontend;
  std::unique_ptr<nn::ThreadPool> loop_threads;  ///< Of the recorder's networks.
  std::optional<vo::LoopRecorder> loops;
  std::shared_ptr<vo::ExtractorMemo> extracted;  ///< The front end's; null without loops.
  bool reads_images = true;
  bool uses_imu = false;
};

/// Gives the options that nothing set the values of the preset, and says which of those that were
/// given are without effect. `setup` has the data set, and of a replay the method.
void ApplyPresetAndWarn(CLI::App& command, const std::map<std::string, bool>& given, bool is_replay,
                        RunArguments& arguments, RunSetup& setup);

/// Whether the inertial unit is used; what has to be there for the options. Throws Error where it
/// is not.
void SetUpImu(const RunArguments& arguments, RunSetup& setup);

/// The part that finds places, on so many threads of its own. Throws Error as vo::MakeLoopRecorder
/// does.
void SetUpLoops(const RunArguments& arguments, const vo::Networks& networks, int threads,
                RunSetup& setup);

/// The front end that the arguments name, with its networks and loops. Where nothing asks for loops
/// and they cannot be had it says so, and turns them off.
void SetUpFrontEnd(CLI::App& command, nn::ThreadPool& pool, RunArguments& arguments,
                   RunSetup& setup);

/// How many threads the kernels of a front end get where the command has so many in all: those that
/// read and write beside it are the others. Networks take so much longer than reading that all
/// threads are theirs.
int KernelThreads(const RunArguments& arguments, int threads);

/// Where there is an inertial unit to use the odometry will use it.
vo::Odometry MakeOdometry(const RunArguments& arguments, RunSetup& setup);

/// All that the record of a run says beside its frames.
RunMetrics::Context MakeContext(const CLI::App& command, const RunArguments& arguments,
                                const RunSetup& setup, const RunRecords& records,
                                const vo::Odometry& odometry, const EarlyEnd& end, int threads);

}  // namespace gluevo::apps
