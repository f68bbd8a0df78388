// gluevo simulate: renders a stereo and inertial sequence with ground truth.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "command_line/message.h"
#include "command_line/value_checks.h"
#include "commands.h"
#include "gluevo/vo/simulation/pairs.h"
#include "gluevo/vo/simulation/simulation.h"
#include "interruption.h"
#include "progress.h"

namespace gluevo::apps {
namespace {

struct SimulateArguments {
  std::filesystem::path output;
  simulation::SimulationOptions options;
  int rooms = 0;  ///< Of training pairs; 0: a sequence.
  std::optional<int> width;
  std::optional<int> height;
};

void Simulate(const SimulateArguments& arguments) {
  const Interruption interruption;
  {
    const bool pairs = arguments.rooms > 0;
    std::unique_ptr<Progress> progress;
    const auto show = [&](int done, int total) {
      Interruption::Check();
      if (progress == nullptr) {
        progress =
            std::make_unique<Progress>(pairs ? "room" : "image", static_cast<std::size_t>(total));
      }
      progress->Update(static_cast<std::size_t>(done), "rendered");
    };
    simulation::SimulationOptions options = arguments.options;
    options.checkpoint = &Interruption::Check;
    if (pairs) {
      simulation::PairOptions pair_options;
      pair_options.rooms = arguments.rooms;
      pair_options.seed = options.seed;
      pair_options.width = arguments.width.value_or(pair_options.width);
      pair_options.height = arguments.height.value_or(pair_options.height);
      pair_options.depth = options.depth;
      pair_options.threads = options.threads;
      pair_options.checkpoint = options.checkpoint;
      simulation::SimulatePairs(pair_options, arguments.output, show);
    } else {
      options.width = arguments.width.value_or(options.width);
      options.height = arguments.height.value_or(options.height);
      simulation::Simulate(options, arguments.output, show);
    }
  }
  std::cout << "data set: " << OneLine(arguments.output.string()) << '\n';
}

void AddImageOptions(CLI::App& command, simulation::ImageOptions& options) {
  command.add_option("--noise", options.noise, "Sensor noise at full white, gray levels")
      ->capture_default_str();
  command
      .add_option("--exposure-change", options.exposure_change,
                  "Let the exposure wander by up to so many stops either way")
      ->capture_default_str();
  command.add_option("--vignetting", options.vignetting, "Share of the light lost in the corners")
      ->capture_default_str();
  command
      .add_option("--motion-blur", options.motion_blur_ms,
                  "Exposure time in milliseconds, in which motion blurs; 0 for sharp images")
      ->capture_default_str();
  command
      .add_option("--light", options.light,
                  "The room's light: 1 bright, 0.1 dusk (darker and noisier images)")
      ->capture_default_str();
}

void AddSceneOptions(CLI::App& command, simulation::SimulationOptions& options) {
  command
      .add_option("--calibration-error", options.calibration_error_mrad,
                  "Write a calibration whose right camera is turned by so many milliradians about "
                  "its vertical axis")
      ->capture_default_str();
  command.add_flag("--twins", options.twins,
                   "Every six metres the room looks the same, but for its end walls: places that "
                   "look alike and are others");
  command
      .add_option("--movers", options.movers,
                  "So many boxes drive or fly through the scene; also writes cam0/movers: masks "
                  "of what moves in the left images")
      ->capture_default_str();
  command
      .add_option("--movers-cover", options.movers_cover,
                  "Share of the left image that each mover fills when it is nearest, at most 0.5")
      ->capture_default_str();
}

}  // namespace

void AddSimulateCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "simulate", "Render a stereo and inertial sequence in EuRoC's layout, with ground truth");
  const auto arguments = std::make_shared<SimulateArguments>();
  simulation::SimulationOptions& options = arguments->options;
  command
      ->add_option("-o,--output", arguments->output,
                   "Folder of the data set to make; must not exist")
      ->required();
  command->add_option("--path", options.path, "Path to fly")
      ->check(OneOf(simulation::SimulationPaths()))
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
  command
      ->add_option("--laps", options.laps,
                   "So many laps of hall_loop, figure_eight or corridor, in place of a duration")
      ->check(Within(1, 100))
      ->excludes("--trajectory")
      ->excludes("--start")
      ->excludes("--duration");
  command->add_option("--rate", options.rate_hz, "Stereo pairs a second")->capture_default_str();
  command->add_option("--width", arguments->width,
                      "Of the images, pixels; default: 752, of training pairs 376");
  command->add_option("--height", arguments->height,
                      "Of the images, pixels; default: 480, of training pairs 240");
  AddImageOptions(*command, options.image);
  command->add_flag("--depth", options.depth,
                    "Also write depth maps: cam0/depth, cam1/depth, float tiff, metres");
  command->add_flag("--correspondences", options.correspondences,
                    "Also write correspondences.h5: where the pixels of a grid are seen in the "
                    "right and in the next image, and their points in the world");
  AddSceneOptions(*command, options);
  CLI::Option* const pairs =
      command
          ->add_option("--pairs", arguments->rooms,
                       "Instead of a sequence, make training data for matchers: so many rooms in 8 "
                       "views each, with exact correspondences, in HDF5 files (--seed, --width, "
                       "--height, --depth and --threads apply)")
          ->check(Within(1, 1'000'000));
  for (const char* option :
       {"--path", "--trajectory", "--start", "--from-takeoff", "--duration", "--laps", "--twins",
        "--rate", "--noise", "--exposure-change", "--vignetting", "--motion-blur", "--light",
        "--correspondences", "--movers", "--movers-cover", "--calibration-error"}) {
    pairs->excludes(command->get_option(option));
  }
  command->add_option("--threads", options.threads, "Threads; default: one for each processor")
      ->check(Within(1, 1024));
  command->footer(
      "Example:\n  gluevo simulate -o data/hall --path hall_loop --duration 20\n"
      "  gluevo simulate -o data/flight --trajectory MH_01.txt --from-takeoff "
      "--duration 60\n"
      "  gluevo simulate -o data/rooms --pairs 1000");
  command->callback([arguments] { Simulate(*arguments); });
}

}  // namespace gluevo::apps
