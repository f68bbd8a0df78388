// gluevo simulate: renders a stereo and inertial sequence with ground truth.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>

#include "commands.h"
#include "gluevo/vo/simulation.h"
#include "progress.h"

namespace gluevo::apps {
namespace {

struct SimulateArguments {
  std::filesystem::path output;
  vo::SimulationOptions options;
};

void Simulate(const SimulateArguments& arguments) {
  {
    std::unique_ptr<Progress> progress;
    vo::Simulate(arguments.options, arguments.output, [&](int done, int total) {
      if (progress == nullptr) {
        progress = std::make_unique<Progress>("image", static_cast<std::size_t>(total));
      }
      progress->Update(static_cast<std::size_t>(done), "rendered");
    });
  }
  std::cout << "data set: " << arguments.output.string() << '\n';
}

}  // namespace

void AddSimulateCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "simulate", "Render a stereo and inertial sequence in EuRoC's layout, with ground truth");
  const auto arguments = std::make_shared<SimulateArguments>();
  vo::SimulationOptions& options = arguments->options;
  command
      ->add_option("-o,--output", arguments->output,
                   "Folder of the data set to make; must not exist")
      ->required();
  command->add_option("--path", options.path, "Path to fly")
      ->check(CLI::IsMember(vo::SimulationPaths()))
      ->capture_default_str();
  command->add_option("--seed", options.seed, "Makes the room and all noise")
      ->capture_default_str();
  command->add_option("--duration", options.duration_s, "Seconds")->capture_default_str();
  command->add_option("--rate", options.rate_hz, "Stereo pairs a second")->capture_default_str();
  command->add_option("--width", options.width, "Of the images, pixels")->capture_default_str();
  command->add_option("--height", options.height, "Of the images, pixels")->capture_default_str();
  command->add_option("--noise", options.noise, "Sensor noise at full white, gray levels")
      ->capture_default_str();
  command->add_option("--threads", options.threads, "Threads; default: one for each processor")
      ->check(CLI::Range(1, 1024));
  command->footer("Example:\n  gluevo simulate -o data/hall --path hall_loop --duration 20");
  command->callback([arguments] { Simulate(*arguments); });
}

}  // namespace gluevo::apps
