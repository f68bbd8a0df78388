// gluevo localize: where frames were taken, in a map that a run has made.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "command_line/message.h"
#include "command_line/value_checks.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/vo/io/output_directory.h"
#include "gluevo/vo/pipeline/localizer_config.h"
#include "interruption.h"
#include "localization_frames.h"
#include "localization_table.h"
#include "options/dataset_options.h"
#include "options/network_options.h"
#include "options/option_group.h"
#include "processors.h"
#include "progress.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct LocalizeArguments {
  fs::path frames;
  fs::path map;
  fs::path output;
  bool is_left_only = false;
  DatasetArguments dataset;
  vo::LocalizerConfig config;
  int threads = 0;
};

void AddLocalizeOptions(CLI::App& command, LocalizeArguments& arguments) {
  command
      .add_option(
          "FRAMES", arguments.frames,
          "Data set, or folder of images (or one image) of a camera like the map's left one")
      ->required();
  command.add_option("--map", arguments.map, "Map, as gluevo run --save-map writes it")->required();
  command.add_option("-o,--output", arguments.output, "Folder for the results")->required();
  command.add_flag("--left-only", arguments.is_left_only,
                   "Of a data set look at the left images alone");
  AddDatasetOptions(command, arguments.dataset);
  AddNetworkOptions(command, arguments.config.networks, arguments.threads);
  AddMatcherOption(command, arguments.config.matcher);
  AddKeypointOptions(command, arguments.config.keypoint_threshold, arguments.config.max_keypoints);
  AddLightGlueOptions(command, arguments.config.lightglue);
  OptionGroup places(command, "Places");
  vo::LocalizationOptions& options = arguments.config.options;
  places.Add("--codebook", arguments.config.codebook,
             "Of places, made by gluevo codebook; without one that of the built-in SuperPoint");
  places.Add("--candidates", options.max_candidates,
             "So many of the most similar key frames are matched with a frame");
  places.Add("--min-inliers", options.min_inliers,
             "A frame is found where so many of its keypoints fit the map");
  places.Add("--max-sigma", options.max_position_sigma_m,
             "A frame is not found where its place is less certain than this, metres (one standard "
             "deviation)");
  command.footer(
      "Writes DIR/trajectory.tum (poses in the map's frame) and DIR/localization.csv (a line for "
      "every frame).\nExample:\n  gluevo run data/morning -o results/morning --save-map house.map\n"
      "  gluevo localize data/evening --map house.map -o results/evening");
}

void CheckOutputs(const LocalizeArguments& arguments, const LocalizationPlaces& places) {
  std::vector<fs::path> inputs = WeightsInputs(arguments.config.networks);
  for (const fs::path& input : {arguments.frames, arguments.map, arguments.config.codebook,
                                arguments.dataset.groundtruth}) {
    inputs.push_back(input);
  }
  inputs.insert(inputs.end(), arguments.dataset.calibration.begin(),
                arguments.dataset.calibration.end());
  CheckOutputsAreNoInputs({places.trajectory, places.table}, inputs);
  CheckReplacesOnlyLocalization(places);
}

// Nothing where the frame cannot be read, which is said.
std::optional<vo::Localization> LocateOrLeaveOut(const LocalizationFrames& frames,
                                                 std::size_t index,
                                                 const vo::MapLocalizer& localizer) {
  std::optional<vo::StereoFrame> frame;
  try {
    frame = frames.Read(index);
  } catch (const Error& error) {
    PrintMessage("gluevo: warning", "frame left out: " + std::string(error.what()));
    return std::nullopt;
  }
  return localizer.Locate(*frame, frames.rig());
}

std::vector<LocalizedFrame> LocateAll(const LocalizationFrames& frames,
                                      const vo::MapLocalizer& localizer) {
  std::vector<LocalizedFrame> located;
  located.reserve(frames.size());
  Progress progress("frame", frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Interruption::Check();
    located.push_back(
        {frames.name(i), frames.timestamp_ns(i), LocateOrLeaveOut(frames, i, localizer)});
    const auto& result = located.back().result;
    progress.Update(i + 1, !result            ? "left out"
                           : result->is_found ? std::to_string(result->inliers) + " inliers"
                                              : "not found");
  }
  return located;
}

void Localize(const LocalizeArguments& arguments) {
  const Interruption interruption;
  arguments.config.options.Validate();
  const LocalizationPlaces places = PlacesIn(arguments.output);
  CheckOutputs(arguments, places);
  vo::PlaceMap map = vo::ReadPlaceMap(arguments.map);
  const LocalizationFrames frames(arguments.frames, arguments.dataset, arguments.is_left_only,
                                  map.rig);
  nn::ThreadPool pool(arguments.threads);
  UseKernelThreads(pool.size());
  const vo::MapLocalizer localizer =
      vo::MakeMapLocalizer(arguments.config, std::move(map), arguments.map.string(), pool);
  const vo::OutputDirectory output(arguments.output);
  for (const fs::path& file : {places.trajectory, places.table}) {
    nn::CheckPlaceForFile(file);
  }
  const std::vector<LocalizedFrame> located = LocateAll(frames, localizer);
  WriteLocalization(places, located, localizer.map());
  std::cout << SummaryOf(located, localizer.map(), frames.groundtruth())
            << "results: " << OneLine(arguments.output.string()) << '\n';
}

}  // namespace

void AddLocalizeCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "localize", "Find frames in a map, each by itself: stereo pairs or single images");
  const auto arguments = std::make_shared<LocalizeArguments>();
  AddLocalizeOptions(*command, *arguments);
  command->callback([arguments] { Localize(*arguments); });
}

}  // namespace gluevo::apps
