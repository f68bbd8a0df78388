// gluevo bench: how fast the networks run on this machine.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench_work.h"
#include "command_line/standard_streams.h"
#include "command_line/value_checks.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/isa.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/nn/peak_share.h"
#include "gluevo/nn/random_weights.h"
#include "gluevo/nn/replaced_file.h"
#include "gluevo/vo/core/text.h"
#include "json_text.h"
#include "options/network_options.h"

namespace gluevo::apps {
namespace {

// By which a file of --output is known again.
constexpr const char* kOutputMark = "gluevo bench";

struct BenchArguments {
  std::string network = "superpoint";
  std::string size = "752x480";
  BenchInputs inputs;
  std::filesystem::path output;
  int rounds = 20;
  int layers = 0;  // Of SuperGlue or LightGlue with random weights; 0: the weights are given.
  bool on_request = false;
  bool json = false;
  vo::NetworkFiles networks;
  nn::LightGlueOptions lightglue;
  int threads = 0;
};

void ParseSize(const std::string& size, BenchInputs& inputs) {
  if (std::sscanf(size.c_str(), "%dx%d", &inputs.width, &inputs.height) != 2 || inputs.width < 8 ||
      inputs.height < 8 || inputs.width > 16384 || inputs.height > 16384) {
    throw OptionError("size " + Quoted(size) + " is not WIDTHxHEIGHT of 8 to 16384 (--size)");
  }
}

bool IsOfFeatures(const std::string& network) {
  return network == "superpoint" || network == "aliked";
}

nn::Precision PrecisionOf(const BenchArguments& arguments) {
  const bool is_bf16 = arguments.network == "superglue" && arguments.networks.precision == "bf16";
  return is_bf16 ? nn::Precision::kBf16 : nn::Precision::kFloat;
}

vo::Networks MakeNetworks(const BenchArguments& arguments) {
  const std::string& network = arguments.network;
  if (arguments.layers == 0) {
    return IsOfFeatures(network) ? vo::LoadNetworks(arguments.networks, network, "")
                                 : vo::LoadMatcher(arguments.networks, "", network);
  }
  vo::Networks networks;
  nn::Weights weights;
  if (network == "superpoint") {
    weights = nn::RandomSuperPointWeights();
    networks.superpoint = std::make_shared<nn::SuperPoint>(weights);
  } else if (network == "aliked") {
    weights = nn::RandomAlikedWeights();
    networks.aliked = std::make_shared<nn::Aliked>(weights);
  } else if (network == "superglue") {
    weights = nn::RandomSuperGlueWeights(arguments.layers);
    networks.superglue = std::make_shared<nn::SuperGlue>(weights, PrecisionOf(arguments));
  } else {
    weights = nn::RandomLightGlueWeights(arguments.layers);
    networks.lightglue = std::make_shared<nn::LightGlue>(weights);
  }
  networks.records.push_back({network, weights.source, weights.checksum});
  return networks;
}

BenchWork MakeWork(const BenchArguments& arguments, const vo::Networks& networks,
                   nn::Workspace& workspace) {
  if (networks.superpoint != nullptr) {
    return MakeSuperPointWork(networks, arguments.inputs, workspace);
  }
  if (networks.aliked != nullptr) {
    return MakeAlikedWork(networks, arguments.inputs, workspace);
  }
  return networks.superglue != nullptr
             ? MakeSuperGlueWork(networks, arguments.inputs, workspace)
             : MakeLightGlueWork(networks, arguments.lightglue, arguments.inputs, workspace);
}

// For whoever alternates this program with others: one timed call for each line that comes in.
void RunOnRequest(const BenchWork& work) {
  std::cout << std::fixed << std::setprecision(4);
  for (std::string line; std::getline(std::cin, line);) {
    const auto start = std::chrono::steady_clock::now();
    work.run();
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
    std::cout << time.count() << '\n';
    CheckStandardOutput();
  }
}

void Report(const BenchArguments& arguments, const vo::Networks& networks, const BenchWork& work,
            int threads) {
  nn::PeakShare peak(PrecisionOf(arguments), threads);
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(arguments.rounds));
  for (int i = 0; i < arguments.rounds; ++i) {
    times.push_back(1e3 * peak.Time(work.flops, work.run));
  }
  std::sort(times.begin(), times.end());
  const double median_ms = times[times.size() / 2];
  const double gflops = 1e-6 * work.flops / median_ms;
  const std::string isa = nn::IsaName(nn::ChooseIsa());
  if (arguments.json) {
    nlohmann::ordered_json json;
    json["network"] = arguments.network;
    json["weights"] = networks.records.front().source;
    if (work.layers > 0) {
      json["layers"] = work.layers;
    }
    json["size"] = work.size;
    json["keypoints"] = work.keypoints;
    json["median_ms"] = median_ms;
    json["min_ms"] = times.front();
    json["gflops"] = gflops;
    json["peak_gflops"] = 1e-9 * peak.peak_flops();
    json["peak_share"] = peak.share();
    json["precision"] = PrecisionOf(arguments) == nn::Precision::kBf16 ? "bf16" : "float";
    json["isa"] = isa;
    json["threads"] = threads;
    std::cout << JsonText(json);
  } else {
    std::cout << arguments.network << ", " << isa << ", " << vo::Counted(threads, "thread")
              << ": median " << median_ms << " ms, least " << times.front() << " ms, "
              << std::lround(gflops) << " GFLOP/s, " << std::lround(100.0 * peak.share())
              << "% of the measured peak of " << std::lround(1e-9 * peak.peak_flops())
              << " GFLOP/s\n";
  }
}

void Bench(BenchArguments arguments) {
  ParseSize(arguments.size, arguments.inputs);
  if (!arguments.output.empty()) {
    std::vector<std::filesystem::path> inputs = WeightsInputs(arguments.networks);
    inputs.insert(inputs.end(), {arguments.inputs.image, arguments.inputs.features});
    CheckOutputsAreNoInputs({arguments.output}, inputs);
    nn::CheckReplacesOnly(arguments.output, kOutputMark, "a file of gluevo bench");
    nn::CheckPlaceForFile(arguments.output);
  }
  nn::ThreadPool pool(arguments.threads);
  nn::Workspace workspace(pool);
  const vo::Networks networks = MakeNetworks(arguments);
  const BenchWork work = MakeWork(arguments, networks, workspace);
  if (!arguments.output.empty()) {
    nn::Weights outputs = work.outputs();
    outputs.metadata["writer"] = kOutputMark;
    nn::WriteSafetensors(arguments.output, outputs);
  }
  work.run();  // Warms up: memory and caches.
  if (arguments.on_request) {
    RunOnRequest(work);
  } else {
    Report(arguments, networks, work, pool.size());
  }
}

}  // namespace

void AddBenchCommand(CLI::App& app) {
  CLI::App* const command =
      app.add_subcommand("bench", "How fast the networks run on this machine");
  const auto arguments = std::make_shared<BenchArguments>();
  BenchInputs& inputs = arguments->inputs;
  command->add_option("--network", arguments->network, "superpoint, superglue, aliked or lightglue")
      ->check(OneOf({"superpoint", "superglue", "aliked", "lightglue"}))
      ->capture_default_str();
  CLI::Option* const size =
      command->add_option("--size", arguments->size, "Of the image, pixels")->capture_default_str();
  CLI::Option* const keypoints =
      command->add_option("--keypoints", inputs.keypoints, "Of each image")
          ->check(Within(1, 100000))
          ->capture_default_str();
  command->add_option("--image", inputs.image, "Image for SuperPoint or ALIKED; default: noise")
      ->excludes(size);
  command
      ->add_option(
          "--features", inputs.features,
          "File with the features of two images for SuperGlue or LightGlue, .safetensors "
          "or .npz with keypoints0, scores0, descriptors0, size0, keypoints1, ...; default: random")
      ->excludes(size)
      ->excludes(keypoints);
  command->add_option("--output", arguments->output,
                      "Write what goes in and what comes out to this .safetensors file");
  CLI::Option* const rounds =
      command->add_option("--rounds", arguments->rounds, "Timed calls, after one that is not")
          ->check(Within(1, 100000))
          ->capture_default_str();
  CLI::Option* const json = command->add_flag("--json", arguments->json, "Print JSON");
  command
      ->add_flag("--on-request", arguments->on_request,
                 "Instead of --rounds: for each line of standard input one timed call, and its "
                 "milliseconds on a line of standard output")
      ->excludes(rounds)
      ->excludes(json);
  AddNetworkOptions(*command, arguments->networks, arguments->threads);
  AddLightGlueOptions(*command, arguments->lightglue);
  CLI::Option* const layers =
      command
          ->add_option("--layers", arguments->layers,
                       "Random weights of the published size, SuperGlue's and LightGlue's with so "
                       "many layers (published: 18 and 9)")
          ->check(Within(1, 100));
  for (const char* const given :
       {"--weights", "--superpoint", "--superglue", "--aliked", "--lightglue"}) {
    layers->excludes(command->get_option(given));
  }
  command->footer(
      "Prints the median and the least time of a call, its floating-point operations a second (as "
      "published: direct convolutions of whole images, of LightGlue's layers those that ran) and "
      "their share of the multiply-adds that as many threads reach on registers alone, measured "
      "before each call.\n\n"
      "Example:\n  gluevo bench --network superglue --keypoints 1024 --threads 2");
  command->callback([arguments] {
    const bool takes_image = IsOfFeatures(arguments->network);
    if (takes_image && !arguments->inputs.features.empty()) {
      throw CLI::ValidationError("--network " + arguments->network + " takes no --features");
    }
    if (!takes_image && !arguments->inputs.image.empty()) {
      throw CLI::ValidationError("--network " + arguments->network + " takes no --image");
    }
    Bench(*arguments);
  });
}

}  // namespace gluevo::apps
