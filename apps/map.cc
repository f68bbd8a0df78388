// gluevo map: what a map holds, two made one, and a map for other programs.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "command_line/message.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/nn/replaced_file.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/io/output_directory.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "gluevo/vo/mapping/map.h"
#include "gluevo/vo/mapping/map_culling.h"
#include "gluevo/vo/mapping/place_map.h"
#include "gluevo/vo/mapping/place_map_export.h"
#include "gluevo/vo/pipeline/localizer_config.h"
#include "interruption.h"
#include "options/loop_options.h"
#include "options/network_options.h"
#include "options/option_group.h"
#include "processors.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

void PrintInfo(const fs::path& path) {
  const vo::PlaceMap map = vo::ReadPlaceMap(path);
  std::map<int, std::size_t> parts;
  for (const int part : map.Parts()) {
    ++parts[part];
  }
  std::size_t keypoints = 0;
  std::size_t points = 0;
  for (const vo::LoopKeyframe& keyframe : map.keyframes) {
    keypoints += keyframe.keypoints.size();
    for (const vo::StereoKeypoint& keypoint : keyframe.keypoints) {
      points += keypoint.inverse_depth > 0.0 ? 1 : 0;
    }
  }
  const vo::Camera& camera = map.rig.cameras[0];
  std::cout << "features: " << OneLine(map.features.network) << ", weights "
            << OneLine(map.features.source) << "\n  SHA-256 " << OneLine(map.features.checksum)
            << "\ncameras: " << camera.width << " x " << camera.height << " px, baseline "
            << map.rig.baseline() << " m; poses of the " << OneLine(map.rig.body_frame) << '\n'
            << "key frames: " << map.keyframes.size() << " with "
            << vo::Counted(keypoints, "keypoint") << ", " << points << " of known depth\n"
            << "loops: " << map.loops.size()
            << " (between key frames of the map: a run closes more where they are culled)\nparts: "
            << parts.size();
  for (const auto& [part, size] : parts) {
    std::cout << (part == parts.begin()->first ? " (" : "; ") << "of segment " << part << ": "
              << vo::Counted(size, "key frame");
  }
  std::cout << (parts.empty() ? "\n" : ")\n");
  if (!map.keyframes.empty()) {
    std::cout << "size: " << fs::file_size(path) / map.keyframes.size() << " bytes a key frame\n";
  }
}

struct ExportArguments {
  fs::path map;
  fs::path output;
};

void Export(const ExportArguments& arguments) {
  const fs::path trajectory = arguments.output / "keyframes.tum";
  const std::vector<fs::path> ply = {arguments.output / "points.ply",
                                     arguments.output / "keyframes.ply"};
  CheckOutputsAreNoInputs({ply[0], ply[1], trajectory}, {arguments.map});
  for (const fs::path& file : ply) {
    nn::CheckReplacesOnly(file, "world frame, metres", "a map of gluevo as PLY");
  }
  constexpr const char* kMark = "in the frame of a map";
  nn::CheckReplacesOnly(trajectory, kMark, "key frames of a map");
  const vo::PlaceMap map = vo::ReadPlaceMap(arguments.map);
  const vo::OutputDirectory output(arguments.output);
  vo::WritePly(arguments.output, vo::SparseMapOf(map));
  vo::WriteTrajectory(trajectory, vo::KeyframesOf(map, map.LargestPart()),
                      vo::TrajectoryFormat::kTum,
                      "pose of the " + map.rig.body_frame + " " + kMark + "'s largest part");
  std::cout << "results: " << OneLine(arguments.output.string()) << '\n';
}

struct MergeArguments {
  fs::path map;
  fs::path more;
  fs::path output;
  vo::LocalizerConfig config;
  vo::LoopOptions loops;
  vo::MapCullingOptions culling;
  int threads = 0;
};

void Merge(const MergeArguments& arguments) {
  const Interruption interruption;
  std::vector<fs::path> inputs = WeightsInputs(arguments.config.networks);
  for (const fs::path& input : {arguments.map, arguments.more, arguments.config.codebook}) {
    inputs.push_back(input);
  }
  CheckOutputsAreNoInputs({arguments.output}, inputs);
  nn::CheckReplacesOnly(arguments.output, "gluevo map", "a map of gluevo");
  nn::CheckPlaceForFile(arguments.output);
  const vo::PlaceMap map = vo::ReadPlaceMap(arguments.map);
  const vo::PlaceMap more = vo::ReadPlaceMap(arguments.more);
  nn::ThreadPool pool(arguments.threads);
  UseKernelThreads(pool.size());
  const vo::PlaceMap merged =
      vo::CullPlaceMap(vo::MergeMaps(arguments.config, arguments.loops, map, arguments.map.string(),
                                     more, arguments.more.string(), pool),
                       arguments.culling);
  vo::WritePlaceMap(arguments.output, merged);
  std::cout << "loops: " << merged.loops.size() << " (" << map.loops.size() << " and "
            << more.loops.size() << " before)\nmap: " << OneLine(arguments.output.string()) << '\n';
}

void AddInfo(CLI::App& map) {
  CLI::App* const command = map.add_subcommand("info", "What a map holds");
  const auto path = std::make_shared<fs::path>();
  command->add_option("MAP", *path, "Map, as gluevo run --save-map writes it")->required();
  command->callback([path] { PrintInfo(*path); });
}

void AddMerge(CLI::App& map) {
  CLI::App* const command = map.add_subcommand(
      "merge", "Make one map of two of the same rig, joined where they show the same places");
  const auto arguments = std::make_shared<MergeArguments>();
  command->add_option("MAP", arguments->map, "Map whose frame stays")->required();
  command->add_option("MORE", arguments->more, "Map to add")->required();
  command->add_option("-o,--output", arguments->output, "Map to write")->required();
  AddNetworkOptions(*command, arguments->config.networks, arguments->threads);
  AddMatcherOption(*command, arguments->config.matcher);
  AddLightGlueOptions(*command, arguments->config.lightglue);
  OptionGroup loops(*command, "Loops");
  loops.Add("--codebook", arguments->config.codebook,
            "Of places, made by gluevo codebook; without one that of the built-in SuperPoint");
  loops.Add("--loop-min-age", arguments->loops.min_age_s,
            "Places are not compared with those of the last so many seconds");
  loops.Add("--loop-candidates", arguments->loops.max_candidates,
            "So many of the similar places are verified by the network");
  AddCullingOption(loops, arguments->culling);
  command->footer("Example:\n  gluevo map merge monday.map tuesday.map -o house.map");
  command->callback([arguments] { Merge(*arguments); });
}

void AddExport(CLI::App& map) {
  CLI::App* const command = map.add_subcommand(
      "export", "Points and key frames as PLY, key frames of the largest part as TUM");
  const auto arguments = std::make_shared<ExportArguments>();
  command->add_option("MAP", arguments->map, "Map, as gluevo run --save-map writes it")->required();
  command->add_option("-o,--output", arguments->output, "Folder for the results")->required();
  command->footer("Example:\n  gluevo map export house.map -o house");
  command->callback([arguments] { Export(*arguments); });
}

}  // namespace

void AddMapCommand(CLI::App& app) {
  CLI::App* const command =
      app.add_subcommand("map", "Maps that runs have made: info, merge, export");
  command->require_subcommand(1);
  AddInfo(*command);
  AddMerge(*command);
  AddExport(*command);
  command->footer("Example:\n  gluevo map info house.map");
}

}  // namespace gluevo::apps
