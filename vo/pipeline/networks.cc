#include "gluevo/vo/pipeline/networks.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/nn/weights.h"
#include "gluevo/vo/frontend/network_matcher.h"

namespace gluevo::vo {
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

Networks LoadNetworks(const NetworkFiles& files, bool with_superglue) {
  std::optional<fs::path> superpoint_file;
  std::optional<fs::path> superglue_file;
  if (!files.weights.empty()) {
    if (!fs::is_directory(files.weights)) {
      throw Error(files.weights.string() + ": not a folder (--weights)");
    }
    superpoint_file = FindWeights(files.weights, "superpoint");
    superglue_file = FindWeights(files.weights, "superglue");
    if (!superpoint_file && !superglue_file) {
      throw Error(files.weights.string() +
                  ": no superpoint.safetensors and no superglue.safetensors in it (--weights)");
    }
  }
  if (!files.superpoint.empty()) {
    superpoint_file = files.superpoint;
  }
  if (!files.superglue.empty()) {
    superglue_file = files.superglue;
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
        superglue, files.precision == "bf16" ? nn::Precision::kBf16 : nn::Precision::kFloat);
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

std::unique_ptr<FeatureExtractor> MakeExtractor(const Networks& networks,
                                                const nn::SuperPointOptions& options,
                                                nn::ThreadPool& pool) {
  return MakeSuperPointExtractor(networks.superpoint, options, pool);
}

std::unique_ptr<Matcher> MakeMatcher(const Networks& networks, nn::ThreadPool& pool) {
  constexpr int kSinkhornIterations = 100;  // As published.
  return networks.superglue != nullptr
             ? MakeSuperGlueMatcher(networks.superglue, kSinkhornIterations, pool)
             : MakeNearestNeighborMatcher();
}

}  // namespace gluevo::vo
