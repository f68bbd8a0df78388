#include "network_options.h"

#include <CLI/CLI.hpp>

namespace gluevo::apps {

void AddNetworkOptions(CLI::App& command, vo::NetworkFiles& files, int& threads) {
  command.add_option("--weights", files.weights,
                     "Folder with superpoint.safetensors and superglue.safetensors (or one file "
                     "of each kind, .npz too); default: the built-in open weights");
  command.add_option("--superpoint", files.superpoint,
                     "Weights file of SuperPoint, .safetensors or .npz");
  command.add_option("--superglue", files.superglue,
                     "Weights file of SuperGlue, .safetensors or .npz");
  command
      .add_option("--precision", files.precision,
                  "Of SuperGlue's matrix products: float, or bf16, which is faster on CPUs with "
                  "AVX512_BF16 (SuperPoint is always float: its Winograd convolutions are faster)")
      ->check(CLI::IsMember({"float", "bf16"}))
      ->capture_default_str();
  command.add_option("--threads", threads, "Threads; default: one for each processor")
      ->check(CLI::Range(1, 1024));
}

void AddSuperPointOptions(CLI::App& command, nn::SuperPointOptions& options) {
  command
      .add_option("--keypoint-threshold", options.keypoint_threshold,
                  "SuperPoint's score above which a pixel is a keypoint")
      ->capture_default_str();
  command
      .add_option("--max-keypoints", options.max_keypoints, "At most so many keypoints an image")
      ->capture_default_str();
}

}  // namespace gluevo::apps
