// gluevo bench: how fast the networks run on this machine.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "commands.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/isa.h"
#include "network_options.h"

namespace gluevo::apps {
namespace {

struct BenchArguments {
  std::string network = "superpoint";
  std::string size = "752x480";
  int keypoints = 500;
  int rounds = 20;
  bool json = false;
  NetworkOptions networks;
  nn::SuperPointOptions superpoint;
};

struct Timing {
  double median_ms = 0.0;
  double min_ms = 0.0;
};

template <typename Work>
Timing Time(int rounds, const Work& work) {
  work();  // Warms up: memory and caches.
  std::vector<double> times;
  for (int i = 0; i < rounds; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count());
  }
  std::sort(times.begin(), times.end());
  return {times[times.size() / 2], times.front()};
}

// Random features: what the networks compute does not depend on the values.
nn::Features RandomFeatures(int count, int descriptor_size, int width, int height, int seed) {
  std::mt19937 generator(static_cast<unsigned>(seed));
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  nn::Features features;
  features.width = width;
  features.height = height;
  features.keypoints.resize(count, 2);
  features.scores.resize(count);
  features.descriptors.resize(count, descriptor_size);
  for (int i = 0; i < count; ++i) {
    features.keypoints.row(i) << uniform(generator) * static_cast<float>(width),
        uniform(generator) * static_cast<float>(height);
    features.scores[i] = uniform(generator);
    for (int d = 0; d < descriptor_size; ++d) {
      features.descriptors(i, d) = uniform(generator) - 0.5F;
    }
    features.descriptors.row(i).normalize();
  }
  return features;
}

void Bench(const BenchArguments& arguments) {
  int width = 0;
  int height = 0;
  if (std::sscanf(arguments.size.c_str(), "%dx%d", &width, &height) != 2 || width < 8 ||
      height < 8 || width > 16384 || height > 16384) {
    throw Error("size " + Quoted(arguments.size) + " is not WIDTHxHEIGHT of 8 to 16384 (--size)");
  }
  nn::ThreadPool pool(arguments.networks.threads);
  nn::Workspace workspace(pool);
  const bool is_superpoint = arguments.network == "superpoint";
  const Networks networks = LoadNetworks(arguments.networks, !is_superpoint);
  Timing timing;
  if (is_superpoint) {
    std::mt19937 generator(1);
    std::vector<uint8_t> pixels(static_cast<std::size_t>(width) * height);
    std::generate(pixels.begin(), pixels.end(),
                  [&] { return static_cast<uint8_t>(generator() % 256); });
    nn::SuperPointOptions options = arguments.superpoint;
    options.max_keypoints = arguments.keypoints;
    nn::Features features;
    timing = Time(arguments.rounds, [&] {
      networks.superpoint->Extract({pixels.data(), width, height, width}, options, workspace,
                                   features);
    });
  } else {
    const int size = networks.superglue->descriptor_size();
    const nn::Features features0 = RandomFeatures(arguments.keypoints, size, width, height, 1);
    const nn::Features features1 = RandomFeatures(arguments.keypoints, size, width, height, 2);
    nn::Matches matches;
    timing = Time(arguments.rounds,
                  [&] { networks.superglue->Match(features0, features1, {}, workspace, matches); });
  }
  if (arguments.json) {
    nlohmann::ordered_json json;
    json["network"] = arguments.network;
    json["size"] = arguments.size;
    json["keypoints"] = arguments.keypoints;
    json["median_ms"] = timing.median_ms;
    json["min_ms"] = timing.min_ms;
    json["isa"] = nn::IsaName(nn::ChooseIsa());
    json["threads"] = pool.size();
    std::cout << json.dump(2) << '\n';
  } else {
    std::cout << arguments.network << ", " << nn::IsaName(nn::ChooseIsa()) << ", " << pool.size()
              << " threads: median " << timing.median_ms << " ms, least " << timing.min_ms
              << " ms\n";
  }
}

}  // namespace

void AddBenchCommand(CLI::App& app) {
  CLI::App* const command =
      app.add_subcommand("bench", "How fast the networks run on this machine");
  const auto arguments = std::make_shared<BenchArguments>();
  command->add_option("--network", arguments->network, "superpoint or superglue")
      ->check(CLI::IsMember({"superpoint", "superglue"}))
      ->capture_default_str();
  command->add_option("--size", arguments->size, "Of the image, pixels")->capture_default_str();
  command->add_option("--keypoints", arguments->keypoints, "Of each image")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--rounds", arguments->rounds, "Timed calls, after one that is not")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "Print JSON");
  AddNetworkOptions(*command, arguments->networks);
  command->footer("Example:\n  gluevo bench --network superglue --keypoints 1024 --threads 2");
  command->callback([arguments] { Bench(*arguments); });
}

}  // namespace gluevo::apps
