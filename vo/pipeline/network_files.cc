#include "gluevo/vo/pipeline/network_files.h"

#include <algorithm>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/nn/weights_folder.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

// Published names of LightGlue's weights begin with those of the features: "aliked_lightglue".
bool IsNamedFor(const std::string& name, const std::string& network) {
  const bool is_lightglue = name.find("lightglue") != std::string::npos;
  return network == "lightglue" ? is_lightglue : !is_lightglue && name.starts_with(network);
}

std::vector<fs::path> Candidates(const fs::path& folder, const std::string& network) {
  if (!fs::is_directory(folder)) {
    throw Error(folder.string() + ": not a folder (--weights)");
  }
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path& path = entry.path();
    if (IsNamedFor(path.filename().string(), network) &&
        (path.extension() == ".safetensors" || path.extension() == ".npz")) {
      found.push_back(path);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

// The one file of a network in a folder, nothing where there is none.
std::optional<fs::path> FindIn(const fs::path& folder, const std::string& network,
                               const std::string& features) {
  const std::vector<fs::path> found = Candidates(folder, network);
  std::vector<std::string> before = {network};
  if (network == "aliked") {
    before.emplace_back("aliked-n16");
  } else if (network == "lightglue" && !features.empty()) {
    before.push_back("lightglue-" + features);
  }
  for (const std::string& name : before) {
    const fs::path path = folder / (name + ".safetensors");
    if (std::find(found.begin(), found.end(), path) != found.end()) {
      return path;
    }
  }
  if (found.size() > 1) {
    throw Error(folder.string() + ": several weights files of " +
                (network == "aliked" ? "an " : "a ") + network + " (" +
                found[0].filename().string() + ", " + found[1].filename().string() +
                ", ...): name one with --" + network);
  }
  return found.empty() ? std::nullopt : std::optional(found[0]);
}

[[noreturn]] void FailForLackOf(const std::string& network, const std::string& features) {
  const std::string file = "name a file with --" + network;
  if (network == "aliked") {
    throw Error("--features aliked needs weights: run gluevo-weights get aliked-n16, or " + file);
  }
  throw Error("--matcher lightglue needs weights" +
              (features == "superpoint" ? " trained on SuperPoint's descriptors: " + file
                                        : ": run gluevo-weights get lightglue-aliked, or " + file));
}

}  // namespace

void CheckFolderHolds(const fs::path& folder, const std::vector<std::string>& networks) {
  std::string names;
  for (const std::string& network : networks) {
    if (!Candidates(folder, network).empty()) {
      return;
    }
    names += (names.empty() ? "no " : " and no ") + network + ".safetensors";
  }
  throw Error(folder.string() + ": " + names + " in it (--weights)");
}

std::optional<fs::path> FindWeights(const NetworkFiles& files, const std::string& network,
                                    const std::string& features) {
  const fs::path& named = network == "superpoint"  ? files.superpoint
                          : network == "superglue" ? files.superglue
                          : network == "aliked"    ? files.aliked
                                                   : files.lightglue;
  if (!named.empty()) {
    return named;
  }
  if (!files.weights.empty()) {
    if (auto found = FindIn(files.weights, network, features)) {
      return found;
    }
  }
  if (network == "superpoint" || network == "superglue") {
    return std::nullopt;
  }
  const fs::path own = nn::UserWeightsFolder();
  std::optional<fs::path> found;
  if (!own.empty() && fs::is_directory(own)) {
    found = FindIn(own, network, features);
  }
  if (!found) {
    FailForLackOf(network, features);
  }
  return found;
}

}  // namespace gluevo::vo
