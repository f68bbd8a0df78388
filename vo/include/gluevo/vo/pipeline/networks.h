#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"
#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/frontend/matcher.h"

namespace gluevo::vo {

/// Which weights the networks have.
struct NetworkFiles {
  /// Folder with superpoint.safetensors and superglue.safetensors (or one file of each kind, .npz
  /// too); empty for the built-in open weights.
  std::filesystem::path weights;
  /// Files that come before what the folder holds; empty for none.
  std::filesystem::path superpoint, superglue;
  /// Of SuperGlue's products: "float" or "bf16".
  std::string precision = "float";
};

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

/// Loads the networks; one that no file is named for is the built-in one. Throws Error for weights
/// that cannot be read, are another network's, or do not fit each other.
Networks LoadNetworks(const NetworkFiles& files, bool with_superglue);

/// The networks as the front ends know them. The pool must outlive what is returned.
std::unique_ptr<FeatureExtractor> MakeExtractor(const Networks& networks,
                                                const nn::SuperPointOptions& options,
                                                nn::ThreadPool& pool);
/// SuperGlue, or mutual nearest neighbours where it is absent.
std::unique_ptr<Matcher> MakeMatcher(const Networks& networks, nn::ThreadPool& pool);

}  // namespace gluevo::vo
