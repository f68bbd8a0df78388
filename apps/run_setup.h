#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/mapping/loop_recorder.h"
#include "gluevo/vo/pipeline/loop_config.h"
#include "gluevo/vo/pipeline/networks.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "options/dataset_options.h"
#include "options/preset_options.h"
#include "run_outputs.h"

namespace gluevo::apps {

/// What the command line of gluevo run says.
struct RunArguments {
  std::filesystem::path dataset;
  RunPlaces places;
  std::filesystem::path config_file;
  std::string preset;
  DatasetArguments frames;
  std::filesystem::path save_matches;
  std::filesystem::path replay;
  bool is_strict = false;
  vo::OdometryConfig config;
  vo::LoopConfig loops;
};

/// Everything that a run needs and that can fail, before its first frame.
struct RunSetup {
  vo::Dataset dataset;
  std::string method;
  std::string features;  ///< Empty where the method has none, as the next.
  std::string matcher;
  OptionOrigins origins;
  vo::Networks networks;
  std::unique_ptr<vo::FrontEnd> frontend;
  std::optional<vo::LoopRecorder> loops;
  bool reads_images = true;
  bool uses_imu = false;
};

/// Opens the data set, loads the networks and makes the front end. `given`: the options that the
/// command line itself has. Throws Error for what is missing or does not go together.
RunSetup SetUp(RunArguments& arguments, CLI::App& command, const std::map<std::string, bool>& given,
               nn::ThreadPool& pool);

}  // namespace gluevo::apps
