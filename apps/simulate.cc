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
  command
      ->add_option("--trajectory", options.trajectory,
                   "TUM or EuRoC file to fly instead: poses of the IMU, z up")
      ->excludes("--path");
  command
      ->add_option("--start", options.start_s,
                   "Seconds after the first pose, or after the take-off, at which to begin")
      ->capture_default_str();
  command->add_flag("--from-takeoff", options.from_takeoff,
                    "Leave out what a trajectory has before its take-off");
  command->add_option("--seed", options.seed, "Makes the room and all noise")
      ->capture_default_str();
  command->add_option("--duration", options.duration_s,
                      "Seconds; default: the whole trajectory, 20 of a named path");
  command->add_option("--rate", options.rate_hz, "Stereo pairs a second")->capture_default_str();
  command->add_option("--width", options.width, "Of the images, pixels")->capture_default_str();
  command->add_option("--height", options.height, "Of the images, pixels")->capture_default_str();
  command->add_option("--noise", options.noise, "Sensor noise at full white, gray levels")
      ->capture_default_str();
  command->add_option("--threads", options.threads, "Threads; default: one for each processor")
      ->check(CLI::Range(1, 1024));
  command->footer(
      "Example:\n  gluevo simulate -o data/hall --path hall_loop --duration 20\n"
      "  gluevo simulate -o data/flight --trajectory MH_01.txt --from-takeoff "
      "--duration 60");
  command->callback([arguments] { Simulate(*arguments); });
}

}  // namespace gluevo::apps
