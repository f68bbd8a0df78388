// gluevo bench: how fast the networks run on this machine.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench_work.h"
#include "commands.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/isa.h"
#include "options/network_options.h"

namespace gluevo::apps {
namespace {

struct BenchArguments {
  std::string network = "superpoint";
  std::string size = "752x480";
  BenchInputs inputs;
  std::filesystem::path output;
  int rounds = 20;
  bool on_request = false;
  bool json = false;
  vo::NetworkFiles networks;
  int threads = 0;
  nn::SuperPointOptions superpoint;
};

void ParseSize(const std::string& size, BenchInputs& inputs) {
  if (std::sscanf(size.c_str(), "%dx%d", &inputs.width, &inputs.height) != 2 || inputs.width < 8 ||
      inputs.height < 8 || inputs.width > 16384 || inputs.height > 16384) {
    throw Error("size " + Quoted(size) + " is not WIDTHxHEIGHT of 8 to 16384 (--size)");
  }
}

double Milliseconds(const BenchWork& work) {
  const auto start = std::chrono::steady_clock::now();
  work.run();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

// For whoever alternates this program with others: one timed call for each line that comes in.
void RunOnRequest(const BenchWork& work) {
  std::cout << std::fixed << std::setprecision(4);
  for (std::string line; std::getline(std::cin, line);) {
    std::cout << Milliseconds(work) << std::endl;
  }
}

void Report(const BenchArguments& arguments, const BenchWork& work, int threads) {
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(arguments.rounds));
  for (int i = 0; i < arguments.rounds; ++i) {
    times.push_back(Milliseconds(work));
  }
  std::sort(times.begin(), times.end());
  const double median_ms = times[times.size() / 2];
  if (arguments.json) {
    nlohmann::ordered_json json;
    json["network"] = arguments.network;
    json["size"] = work.size;
    json["keypoints"] = work.keypoints;
    json["median_ms"] = median_ms;
    json["min_ms"] = times.front();
    json["isa"] = nn::IsaName(nn::ChooseIsa());
    json["threads"] = threads;
    std::cout << json.dump(2) << '\n';
  } else {
    std::cout << arguments.network << ", " << nn::IsaName(nn::ChooseIsa()) << ", " << threads
              << " threads: median " << median_ms << " ms, least " << times.front() << " ms\n";
  }
}

void Bench(BenchArguments arguments) {
  ParseSize(arguments.size, arguments.inputs);
  nn::ThreadPool pool(arguments.threads);
  nn::Workspace workspace(pool);
  const bool is_superpoint = arguments.network == "superpoint";
  const vo::Networks networks = vo::LoadNetworks(arguments.networks, !is_superpoint);
  arguments.superpoint.max_keypoints = arguments.inputs.keypoints;
  const BenchWork work = is_superpoint ? MakeSuperPointWork(networks, arguments.superpoint,
                                                            arguments.inputs, workspace)
                                       : MakeSuperGlueWork(networks, arguments.inputs, workspace);
  if (!arguments.output.empty()) {
    nn::WriteSafetensors(arguments.output, work.outputs());
  }
  work.run();  // Warms up: memory and caches.
  if (arguments.on_request) {
    RunOnRequest(work);
  } else {
    Report(arguments, work, pool.size());
  }
}

}  // namespace

void AddBenchCommand(CLI::App& app) {
  CLI::App* const command =
      app.add_subcommand("bench", "How fast the networks run on this machine");
  const auto arguments = std::make_shared<BenchArguments>();
  BenchInputs& inputs = arguments->inputs;
  command->add_option("--network", arguments->network, "superpoint or superglue")
      ->check(CLI::IsMember({"superpoint", "superglue"}))
      ->capture_default_str();
  CLI::Option* const size =
      command->add_option("--size", arguments->size, "Of the image, pixels")->capture_default_str();
  CLI::Option* const keypoints =
      command->add_option("--keypoints", inputs.keypoints, "Of each image")
          ->check(CLI::Range(1, 100000))
          ->capture_default_str();
  command->add_option("--image", inputs.image, "Image for SuperPoint; default: noise")
      ->excludes(size);
  command
      ->add_option("--features", inputs.features,
                   "File with the features of two images for SuperGlue, .safetensors or .npz with "
                   "keypoints0, scores0, descriptors0, size0, keypoints1, ...; default: random")
      ->excludes(size)
      ->excludes(keypoints);
  command->add_option("--output", arguments->output,
                      "Write what goes in and what comes out to this .safetensors file");
  CLI::Option* const rounds =
      command->add_option("--rounds", arguments->rounds, "Timed calls, after one that is not")
          ->check(CLI::Range(1, 100000))
          ->capture_default_str();
  CLI::Option* const json = command->add_flag("--json", arguments->json, "Print JSON");
  command
      ->add_flag("--on-request", arguments->on_request,
                 "Instead of --rounds: for each line of standard input one timed call, and its "
                 "milliseconds on a line of standard output")
      ->excludes(rounds)
      ->excludes(json);
  AddNetworkOptions(*command, arguments->networks, arguments->threads);
  command->footer("Example:\n  gluevo bench --network superglue --keypoints 1024 --threads 2");
  command->callback([arguments] {
    const bool is_superpoint = arguments->network == "superpoint";
    if (is_superpoint && !arguments->inputs.features.empty()) {
      throw CLI::ValidationError("SuperPoint takes no --features");
    }
    if (!is_superpoint && !arguments->inputs.image.empty()) {
      throw CLI::ValidationError("SuperGlue takes no --image");
    }
    Bench(*arguments);
  });
}

}  // namespace gluevo::apps
