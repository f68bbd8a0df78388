// gluevo weights: which weights are here, and what takes them.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "command_line/message.h"
#include "commands.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/weights.h"
#include "gluevo/nn/weights_folder.h"
#include "gluevo/vo/pipeline/network_files.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

std::string MetadataOf(const nn::Weights& weights, const std::string& key) {
  const auto found = weights.metadata.find(key);
  return found == weights.metadata.end() ? "" : OneLine(found->second);
}

// By a tensor that only this kind has. What is none of them is refused as a SuperPoint.
std::string NetworkOf(const nn::Weights& weights) {
  return weights.Has("desc_head.agg_weights") ? "aliked"
         : weights.Has("posenc.Wr.weight")    ? "lightglue"
         : weights.Has("bin_score")           ? "superglue"
                                              : "superpoint";
}

// Throws Error for weights that do not make a network.
std::string SizesOf(const nn::Weights& weights, const std::string& network) {
  const auto text = [](int layers, int descriptor_size) {
    return (layers > 0 ? std::to_string(layers) + " layers, " : "") + "descriptors of " +
           std::to_string(descriptor_size);
  };
  if (network == "aliked") {
    return text(0, nn::Aliked(weights).descriptor_size());
  }
  if (network == "lightglue") {
    const nn::LightGlue lightglue(weights);
    return text(lightglue.layers(), lightglue.descriptor_size());
  }
  if (network == "superglue") {
    const nn::SuperGlue superglue(weights);
    return text(superglue.layers(), superglue.descriptor_size());
  }
  return text(0, nn::SuperPoint(weights).descriptor_size());
}

// Whether commands find the file when no option names one.
bool IsFound(const fs::path& file, const std::string& network, const std::string& features) {
  try {
    return vo::FindWeights({}, network, features) == file;
  } catch (const Error&) {
    return false;  // Several are there, none of them before the others.
  }
}

std::string TakenBy(const fs::path& file, const std::string& network,
                    const std::string& trained_on) {
  const std::string named = " --" + network + " " + file.string();
  if (network == "superpoint" || network == "superglue") {
    return "taken by" + named;
  }
  if (network == "aliked" || trained_on == "aliked" || trained_on.empty()) {
    return "taken by --features aliked" + (IsFound(file, network, "aliked") ? "" : named);
  }
  if (trained_on == "superpoint") {
    return "taken by --features superpoint --matcher lightglue" +
           (IsFound(file, network, trained_on) ? "" : named);
  }
  return "taken by gluevo match FEATURES.h5 --matcher lightglue" + named + ", for features of " +
         trained_on + " that another program found";
}

void Print(const std::string& name, const nn::Weights& weights, const std::string& taken_by) {
  const std::string network = NetworkOf(weights);
  const std::string sizes = SizesOf(weights, network);
  const std::string licence = MetadataOf(weights, "licence");
  std::cout << "  " << name << ": " << network << ", " << sizes
            << "\n    licence: " << (licence.empty() ? "not stated" : licence) << "\n    "
            << OneLine(taken_by) << '\n';
}

void PrintFile(const fs::path& file) {
  const std::string name = OneLine(file.filename().string());
  try {
    const nn::Weights weights = nn::ReadWeights(file);
    Print(name, weights, TakenBy(file, NetworkOf(weights), MetadataOf(weights, "features")));
  } catch (const Error& error) {
    std::cout << "  " << name << ": cannot be used: " << OneLine(error.what()) << '\n';
  }
}

void ListWeights() {
  std::cout << "built in\n";
  Print("superpoint", nn::OpenSuperPointWeights(), "taken by --features superpoint, the default");
  Print("superglue", nn::OpenSuperGlueWeights(), "taken by --matcher superglue, the default");
  const fs::path folder = nn::UserWeightsFolder();
  std::vector<fs::path> files;
  if (!folder.empty() && fs::is_directory(folder)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      const fs::path& path = entry.path();
      if (path.extension() == ".safetensors" || path.extension() == ".npz") {
        files.push_back(path);
      }
    }
  }
  std::sort(files.begin(), files.end());
  if (!folder.empty()) {
    std::cout << OneLine(folder.string()) << '\n';
  }
  for (const fs::path& file : files) {
    PrintFile(file);
  }
  if (files.empty()) {
    std::cout << "  none; gluevo-weights get aliked-n16 fetches ALIKED and its LightGlue\n";
  }
}

}  // namespace

void AddWeightsCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "weights", "Which weights are here: built in, and in the user's own folder");
  command->footer(
      "The folder is $XDG_DATA_HOME/gluevo/weights or ~/.local/share/gluevo/weights.\n"
      "Example:\n  gluevo weights");
  command->callback([] { ListWeights(); });
}

}  // namespace gluevo::apps
