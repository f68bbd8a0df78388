#include "network_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/nn/weights.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

// The one file of a network in a folder: KIND.safetensors, else the only .safetensors or .npz whose
// name starts with KIND; nothing where there is none.
std::optional<fs::path> FindWeights(const fs::path& folder, const std::string& kind) {
  if (fs::exists(folder / (kind + ".safetensors"))) {
    return folder / (kind + ".safetensors");
  }
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path& path = entry.path();
    if (path.filename().string().starts_with(kind) &&
        (path.extension() == ".safetensors" || path.extension() == ".npz")) {
      found.push_back(path);
    }
  }
  if (found.size() > 1) {
    std::sort(found.begin(), found.end());
    throw Error(folder.string() + ": several weights files of a " + kind + " (" +
                found[0].filename().string() + ", " + found[1].filename().string() +
                ", ...): name one with --" + kind);
  }
  return found.empty() ? std::nullopt : std::optional(found[0]);
}

}  // namespace

void AddNetworkOptions(CLI::App& command, NetworkOptions& options) {
  command.add_option("--weights", options.weights,
                     "Folder with superpoint.safetensors and superglue.safetensors (or one file "
                     "of each kind, .npz too); default: the built-in open weights");
  command.add_option("--superpoint", options.superpoint,
                     "Weights file of SuperPoint, .safetensors or .npz");
  command.add_option("--superglue", options.superglue,
                     "Weights file of SuperGlue, .safetensors or .npz");
  command
      .add_option("--precision", options.precision,
                  "Of SuperGlue's matrix products: float, or bf16, which is faster on CPUs with "
                  "AVX512_BF16 (SuperPoint is always float: its Winograd convolutions are faster)")
      ->check(CLI::IsMember({"float", "bf16"}))
      ->capture_default_str();
  command.add_option("--threads", options.threads, "Threads; default: one for each processor")
      ->check(CLI::Range(1, 1024));
}

void AddSuperPointOptions(CLI::App& command, nn::SuperPointOptions& options) {
  command
      .add_option("--keypoint-threshold", options.keypoint_threshold,
                  "SuperPoint's score above which a pixel is a keypoint")
      ->capture_default_str();
  command
      .add_option("--max-keypoints", options.max_keypoints, "At most so many keypoints an image")
      ->capture_default_str();
}

Networks LoadNetworks(const NetworkOptions& options, bool with_superglue) {
  std::optional<fs::path> superpoint_file;
  std::optional<fs::path> superglue_file;
  if (!options.weights.empty()) {
    if (!fs::is_directory(options.weights)) {
      throw Error(options.weights.string() + ": not a folder (--weights)");
    }
    superpoint_file = FindWeights(options.weights, "superpoint");
    superglue_file = FindWeights(options.weights, "superglue");
    if (!superpoint_file && !superglue_file) {
      throw Error(options.weights.string() +
                  ": no superpoint.safetensors and no superglue.safetensors in it (--weights)");
    }
  }
  if (!options.superpoint.empty()) {
    superpoint_file = options.superpoint;
  }
  if (!options.superglue.empty()) {
    superglue_file = options.superglue;
  }

  Networks networks;
  const nn::Weights superpoint =
      superpoint_file ? nn::ReadWeights(*superpoint_file) : nn::OpenSuperPointWeights();
  networks.superpoint = std::make_shared<nn::SuperPoint>(superpoint);
  networks.superpoint_record = {superpoint.source, superpoint.checksum};
  if (with_superglue) {
    const nn::Weights superglue =
        superglue_file ? nn::ReadWeights(*superglue_file) : nn::OpenSuperGlueWeights();
    networks.superglue = std::make_shared<nn::SuperGlue>(
        superglue, options.precision == "bf16" ? nn::Precision::kBf16 : nn::Precision::kFloat);
    networks.superglue_record = {superglue.source, superglue.checksum};
    if (networks.superpoint->descriptor_size() != networks.superglue->descriptor_size()) {
      throw Error(superglue.source + ": a SuperGlue for descriptors of " +
                  std::to_string(networks.superglue->descriptor_size()) + " values cannot match " +
                  "those of " + superpoint.source + ", which have " +
                  std::to_string(networks.superpoint->descriptor_size()));
    }
  }
  return networks;
}

}  // namespace gluevo::apps
