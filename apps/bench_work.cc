#include "bench_work.h"

#include <algorithm>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/nn/random_inputs.h"
#include "gluevo/vo/io/image_file.h"

namespace gluevo::apps {
namespace {

using nn::Shape;
using nn::Tensor;
using RowMajor = nn::Features::RowMajor;

cv::Mat Noise(int width, int height) {
  std::vector<uint8_t> pixels = nn::RandomPixels(width, height);
  return cv::Mat(height, width, CV_8UC1, pixels.data()).clone();
}

nn::Features RandomFeatures(const BenchInputs& inputs, int descriptor_size, unsigned seed) {
  return nn::RandomFeatures(inputs.keypoints, descriptor_size, inputs.width, inputs.height, seed);
}

nn::Features FeaturesOf(const nn::Weights& file, const std::string& image) {
  const auto get = [&](const std::string& name, int64_t rank) -> const Tensor<float>& {
    const Tensor<float>& tensor = file.Get(name + image);
    if (tensor.shape().rank() != rank) {
      throw Error(file.source + ": " + name + image + " has shape " + tensor.shape().ToString() +
                  ", expected " + std::to_string(rank) + " axes");
    }
    return tensor;
  };
  const Tensor<float>& size = get("size", 1);
  const Tensor<float>& scores = get("scores", 1);
  const Tensor<float>& descriptors = get("descriptors", 2);
  const int64_t count = scores.extent(0);
  CheckShape(size.shape(), {2}, file.source + ": size" + image);
  CheckShape(descriptors.shape(), {count, descriptors.extent(1)},
             file.source + ": descriptors" + image);
  if (count < 1 || !(size[0] >= 1.0F) || !(size[1] >= 1.0F) || size[0] > 1e6F || size[1] > 1e6F) {
    throw Error(file.source + ": image " + image + " has " + std::to_string(count) +
                " keypoints and a size of " + std::to_string(size[0]) + " x " +
                std::to_string(size[1]) + ", expected at least one of each and at most 1e6 pixels");
  }
  nn::Features features;
  features.width = static_cast<int>(size[0]);
  features.height = static_cast<int>(size[1]);
  features.keypoints = file.Get("keypoints" + image, Shape{count, 2}).Matrix();
  features.scores = scores.view().Vector();
  features.descriptors = descriptors.Matrix();
  return features;
}

std::string SizeOf(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

Tensor<float> TensorOf(const RowMajor& matrix) {
  Tensor<float> tensor({matrix.rows(), matrix.cols()});
  tensor.Matrix() = matrix;
  return tensor;
}

template <typename Values>
Tensor<float> TensorOfList(const Values& values) {
  Tensor<float> tensor({static_cast<int64_t>(std::size(values))});
  std::copy(std::begin(values), std::end(values), tensor.data());
  return tensor;
}

void AddFeatures(const nn::Features& features, const std::string& image, nn::Weights& to) {
  to.tensors["keypoints" + image] = TensorOf(features.keypoints);
  to.tensors["scores" + image] = TensorOfList(features.scores);
  to.tensors["descriptors" + image] = TensorOf(features.descriptors);
}

cv::Mat ImageOf(const BenchInputs& inputs) {
  return inputs.image.empty() ? Noise(inputs.width, inputs.height)
                              : vo::ReadGrayImage(inputs.image).pixels;
}

nn::GrayImage View(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step)};
}

void AddImage(const cv::Mat& image, nn::Weights& to) {
  to.tensors["image"] = Tensor<float>({image.rows, image.cols});
  std::copy(image.begin<uchar>(), image.end<uchar>(), to.tensors["image"].data());
}

std::shared_ptr<const FeaturePair> PairOf(const BenchInputs& inputs, int descriptor_size) {
  return std::make_shared<const FeaturePair>(
      inputs.features.empty() ? FeaturePair{RandomFeatures(inputs, descriptor_size, 1),
                                            RandomFeatures(inputs, descriptor_size, 2)}
                              : ReadFeaturePair(inputs.features));
}

// What goes into a matcher, and the matches.
nn::Weights MatcherTensors(const FeaturePair& pair, const nn::Matches& matches) {
  nn::Weights tensors;
  tensors.tensors["matches0"] = TensorOfList(matches.matches0);
  tensors.tensors["matching_scores0"] = TensorOfList(matches.scores0);
  for (const auto& [image, features] :
       {std::pair("0", &pair.features0), std::pair("1", &pair.features1)}) {
    AddFeatures(*features, image, tensors);
    tensors.tensors[std::string("size") + image] =
        TensorOfList(std::vector{features->width, features->height});
  }
  return tensors;
}

}  // namespace

FeaturePair ReadFeaturePair(const std::filesystem::path& path) {
  const nn::Weights file = nn::ReadWeights(path);
  return {FeaturesOf(file, "0"), FeaturesOf(file, "1")};
}

BenchWork MakeSuperPointWork(const vo::Networks& networks, const BenchInputs& inputs,
                             nn::Workspace& workspace) {
  const cv::Mat image = ImageOf(inputs);
  const nn::SuperPointOptions options = {.max_keypoints = inputs.keypoints};
  const auto extract = [=, &workspace](nn::Features& features) {
    networks.superpoint->Extract(View(image), options, workspace, features);
  };
  const auto run = [extract, features = nn::Features()]() mutable { extract(features); };
  const auto outputs = [=, &workspace] {
    nn::Weights tensors;
    nn::Features features;
    extract(features);
    AddFeatures(features, "", tensors);
    AddImage(image, tensors);
    const nn::SuperPoint::DenseMaps maps = networks.superpoint->Dense(View(image), workspace);
    tensors.tensors["score_map"] = TensorOf(maps.scores.Matrix());
    const nn::TensorView<float> cells = maps.descriptors;
    Tensor<float> channels_first({cells.extent(2), cells.extent(0), cells.extent(1)});
    channels_first.view().Reshaped({cells.extent(2), cells.extent(0) * cells.extent(1)}).Matrix() =
        cells.Matrix().transpose();
    tensors.tensors["descriptor_map"] = std::move(channels_first);
    return tensors;
  };
  return {.size = SizeOf(image.cols, image.rows),
          .keypoints = options.max_keypoints,
          .flops = networks.superpoint->Flops(image.cols, image.rows),
          .run = run,
          .outputs = outputs};
}

BenchWork MakeAlikedWork(const vo::Networks& networks, const BenchInputs& inputs,
                         nn::Workspace& workspace) {
  const cv::Mat image = ImageOf(inputs);
  const nn::AlikedOptions options = {.keypoint_threshold = 0.0F, .max_keypoints = inputs.keypoints};
  const auto extract = [=, &workspace](nn::Features& features) {
    networks.aliked->Extract(View(image), options, workspace, features);
  };
  const auto run = [extract, features = nn::Features()]() mutable { extract(features); };
  const auto outputs = [=, &workspace] {
    nn::Weights tensors;
    nn::Features features;
    extract(features);
    AddFeatures(features, "", tensors);
    AddImage(image, tensors);
    tensors.tensors["score_map"] =
        TensorOf(networks.aliked->Scores(View(image), workspace).Matrix());
    return tensors;
  };
  return {.size = SizeOf(image.cols, image.rows),
          .keypoints = options.max_keypoints,
          .flops = networks.aliked->Flops(image.cols, image.rows, options.max_keypoints),
          .run = run,
          .outputs = outputs};
}

BenchWork MakeSuperGlueWork(const vo::Networks& networks, const BenchInputs& inputs,
                            nn::Workspace& workspace) {
  const auto pair = PairOf(inputs, networks.superglue->descriptor_size());
  const auto match = [=, &workspace](nn::Matches& matches) {
    networks.superglue->Match(pair->features0, pair->features1, {}, workspace, matches);
  };
  const auto run = [match, matches = nn::Matches()]() mutable { match(matches); };
  const auto outputs = [=, &workspace] {
    nn::Matches matches;
    match(matches);
    nn::Weights tensors = MatcherTensors(*pair, matches);
    tensors.tensors["log_assignment"] =
        TensorOf(networks.superglue->LogAssignment(pair->features0, pair->features1, {}, workspace)
                     .Matrix());
    return tensors;
  };
  return {.size = SizeOf(pair->features0.width, pair->features0.height),
          .keypoints = pair->features0.size(),
          .layers = networks.superglue->layers(),
          .flops = networks.superglue->Flops(pair->features0.size(), pair->features1.size()),
          .run = run,
          .outputs = outputs};
}

BenchWork MakeLightGlueWork(const vo::Networks& networks, const nn::LightGlueOptions& given,
                            const BenchInputs& inputs, nn::Workspace& workspace) {
  nn::LightGlueOptions options = given;
  if (!networks.lightglue->has_adaptive_depth()) {
    options.depth_confidence = 0.0F;
  }
  const auto pair = PairOf(inputs, networks.lightglue->descriptor_size());
  const auto match = [=, &workspace](nn::Matches& matches, nn::LightGlueEffort* effort) {
    networks.lightglue->Match(pair->features0, pair->features1, options, workspace, matches,
                              effort);
  };
  const auto run = [match, matches = nn::Matches()]() mutable { match(matches, nullptr); };
  const auto outputs = [=, &workspace] {
    nn::Matches matches;
    match(matches, nullptr);
    nn::Weights tensors = MatcherTensors(*pair, matches);
    tensors.tensors["log_assignment"] = TensorOf(
        networks.lightglue->LogAssignment(pair->features0, pair->features1, workspace).Matrix());
    return tensors;
  };
  nn::Matches matches;
  nn::LightGlueEffort effort;
  match(matches, &effort);
  return {.size = SizeOf(pair->features0.width, pair->features0.height),
          .keypoints = pair->features0.size(),
          .layers = effort.layers,
          .flops = networks.lightglue->Flops(pair->features0.size(), pair->features1.size(),
                                             effort.layers),
          .run = run,
          .outputs = outputs};
}

}  // namespace gluevo::apps
