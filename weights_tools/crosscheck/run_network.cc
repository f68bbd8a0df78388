// Converts a weights file of any form, runs the network on given inputs and writes what it gives:
//   run_network WEIGHTS INPUT.safetensors OUTPUT.safetensors
// The input holds "image" [height x width] (then the output "scores" and "descriptors", dense), or
// "size", "keypointsN", "scoresN" and "descriptorsN" of two images (then the output
// "log_assignment", "matches0" and "matching_scores0").

#include <algorithm>
#include <cstring>
#include <exception>
#include <iostream>
#include <string>

#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"
#include "gluevo/weights_tools/convert.h"

namespace gluevo::weights_tools {
namespace {

using nn::Tensor;
using nn::TensorView;
using nn::Weights;

Tensor<float> Copy(const TensorView<float>& view) {
  Tensor<float> copy(view.shape());
  std::copy_n(view.data(), view.size(), copy.data());
  return copy;
}

Weights RunSuperPoint(const Weights& weights, const Tensor<float>& image,
                      nn::Workspace& workspace) {
  const std::vector<uint8_t> pixels(image.data(), image.data() + image.size());
  const nn::GrayImage gray{pixels.data(), static_cast<int>(image.extent(1)),
                           static_cast<int>(image.extent(0)), image.extent(1)};
  const nn::SuperPoint superpoint(weights);
  const nn::SuperPoint::DenseMaps maps = superpoint.Dense(gray, workspace);
  Weights output;
  output.tensors.emplace("scores", Copy(maps.scores));
  output.tensors.emplace("descriptors", Copy(maps.descriptors));
  return output;
}

nn::Features FeaturesOf(const Weights& input, const std::string& image) {
  nn::Features features;
  features.width = static_cast<int>(input.Get("size")[0]);
  features.height = static_cast<int>(input.Get("size")[1]);
  features.keypoints = input.Get("keypoints" + image).Matrix();
  features.scores = input.Get("scores" + image).view().Vector();
  features.descriptors = input.Get("descriptors" + image).Matrix();
  return features;
}

Weights RunSuperGlue(const Weights& weights, const Weights& input, nn::Workspace& workspace) {
  const nn::SuperGlue superglue(weights);
  const nn::Features first = FeaturesOf(input, "0");
  const nn::Features second = FeaturesOf(input, "1");
  Weights output;
  output.tensors.emplace("log_assignment",
                         Copy(superglue.LogAssignment(first, second, {}, workspace)));
  nn::Matches matches;
  superglue.Match(first, second, {}, workspace, matches);
  Tensor<float> indices(nn::Shape{first.size()});
  Tensor<float> scores(nn::Shape{first.size()});
  std::copy(matches.matches0.begin(), matches.matches0.end(), indices.data());
  std::copy(matches.scores0.begin(), matches.scores0.end(), scores.data());
  output.tensors.emplace("matches0", std::move(indices));
  output.tensors.emplace("matching_scores0", std::move(scores));
  return output;
}

void Run(const std::string& weights_path, const std::string& input_path,
         const std::string& output_path) {
  const Weights input = nn::ReadWeights(input_path);
  const bool superpoint = input.Has("image");
  const Weights weights =
      Convert({weights_path}, {.network = superpoint ? "superpoint" : "superglue"}).at(0);
  nn::ThreadPool pool(1);
  nn::Workspace workspace(pool);
  nn::WriteSafetensors(output_path, superpoint
                                        ? RunSuperPoint(weights, input.Get("image"), workspace)
                                        : RunSuperGlue(weights, input, workspace));
}

}  // namespace
}  // namespace gluevo::weights_tools

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: run_network WEIGHTS INPUT OUTPUT\n";
    return 2;
  }
  try {
    gluevo::weights_tools::Run(argv[1], argv[2], argv[3]);
  } catch (const std::exception& error) {
    std::cerr << "run_network: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
