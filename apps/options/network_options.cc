#include "network_options.h"

#include <CLI/CLI.hpp>

#include "command_line/value_checks.h"
#include "option_group.h"

namespace gluevo::apps {
namespace {

constexpr const char* kKeypointThresholdHelp =
    "Score above which a pixel is a keypoint; default: 0.005 of SuperPoint's, 0.2 of ALIKED's";

void AddMaxKeypointsOption(CLI::App& command, int& max_keypoints) {
  command.add_option("--max-keypoints", max_keypoints, "At most so many keypoints an image")
      ->check(AtLeast(1))
      ->capture_default_str();
}

}  // namespace

void AddNetworkOptions(CLI::App& command, vo::NetworkFiles& files, int& threads) {
  command.add_option("--weights", files.weights,
                     "Folder with superpoint.safetensors, superglue.safetensors, "
                     "aliked.safetensors, lightglue.safetensors (or one file of each kind, .npz "
                     "too); default: the built-in open weights, and for ALIKED and LightGlue what "
                     "gluevo-weights get has fetched");
  command.add_option("--superpoint", files.superpoint,
                     "Weights file of SuperPoint, .safetensors or .npz");
  command.add_option("--superglue", files.superglue,
                     "Weights file of SuperGlue, .safetensors or .npz");
  command.add_option("--aliked", files.aliked, "Weights file of ALIKED, .safetensors or .npz");
  command.add_option("--lightglue", files.lightglue,
                     "Weights file of LightGlue, .safetensors or .npz");
  command
      .add_option("--precision", files.precision,
                  "Of SuperGlue's matrix products: float, or bf16, which is faster on CPUs with "
                  "AVX512_BF16 (the other networks are always float)")
      ->check(OneOf({"float", "bf16"}))
      ->capture_default_str();
  command.add_option("--threads", threads, "Threads; default: one for each processor")
      ->check(Within(1, 1024));
}

void AddFeaturesOption(CLI::App& command, std::string& features) {
  command.add_option("--features", features, "What finds and describes keypoints")
      ->check(OneOf({"superpoint", "aliked"}))
      ->capture_default_str();
}

void AddMatcherOption(CLI::App& command, std::string& matcher) {
  command
      .add_option("--matcher", matcher,
                  "What matches keypoints: superglue, lightglue, or nn for mutual nearest "
                  "neighbours; default: superglue for SuperPoint, lightglue for ALIKED")
      ->check(OneOf({"superglue", "lightglue", "nn"}));
}

void AddLightGlueOptions(CLI::App& command, nn::LightGlueOptions& options) {
  OptionGroup tuning(command, "Tuning");
  tuning
      .Add("--depth-confidence", options.depth_confidence,
           "LightGlue runs no more layers once more than this share of the keypoints is sure of "
           "its match; 0: all layers")
      ->check(Share());
  tuning
      .Add("--width-confidence", options.width_confidence,
           "Keypoints leave LightGlue that have, with more than this confidence, no match; 0: "
           "none leaves")
      ->check(Share());
}

void AddKeypointOptions(CLI::App& command, vo::KeypointOptions& options) {
  command.add_option("--keypoint-threshold", options.keypoint_threshold, kKeypointThresholdHelp)
      ->check(Share())
      ->capture_default_str();
  AddMaxKeypointsOption(command, options.max_keypoints);
}

void AddKeypointOptions(CLI::App& command, std::optional<float>& threshold, int& max_keypoints) {
  command.add_option("--keypoint-threshold", threshold, kKeypointThresholdHelp)->check(Share());
  AddMaxKeypointsOption(command, max_keypoints);
}

std::vector<std::filesystem::path> WeightsInputs(const vo::NetworkFiles& files) {
  return {files.weights, files.superpoint, files.superglue, files.aliked, files.lightglue};
}

}  // namespace gluevo::apps
