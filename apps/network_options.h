#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "command_line.h"
#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"
#include "gluevo/nn/thread_pool.h"

namespace gluevo::apps {

/// Which networks a command runs, as the options common to all commands say.
struct NetworkOptions {
  std::filesystem::path weights;     ///< Folder; empty for the built-in open weights.
  std::filesystem::path superpoint;  ///< File; before what the folder holds.
  std::filesystem::path superglue;
  std::string precision = "float";  ///< Of SuperGlue's products: float or bf16.
  int threads = 0;                  ///< 0: one a processor.
};

void AddNetworkOptions(CLI::App& command, NetworkOptions& options);

void AddSuperPointOptions(CLI::App& command, nn::SuperPointOptions& options);

/// Name and checksum of a network's weights, for records.
struct WeightsRecord {
  std::string source;
  std::string checksum;
};

struct Networks {
  WeightsRecord superpoint_record;
  WeightsRecord superglue_record;
  std::shared_ptr<const nn::SuperPoint> superpoint;
  std::shared_ptr<const nn::SuperGlue> superglue;  ///< Absent where it was not asked for.
};

/// Loads the networks; one that no option names is the built-in one. Throws Error for weights that
/// cannot be read, are another network's, or do not fit each other.
Networks LoadNetworks(const NetworkOptions& options, bool with_superglue);

}  // namespace gluevo::apps
