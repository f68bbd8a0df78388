#include "bench_work.h"

#include <algorithm>
#include <opencv2/core/mat.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/image_file.h"

namespace gluevo::apps {
namespace {

using nn::Shape;
using nn::Tensor;
using RowMajor = nn::Features::RowMajor;

cv::Mat Noise(int width, int height) {
  std::mt19937 generator(1);
  cv::Mat image(height, width, CV_8UC1);
  std::generate(image.begin<uchar>(), image.end<uchar>(),
                [&] { return static_cast<uchar>(generator() % 256); });
  return image;
}

// What the networks compute does not depend on the values.
nn::Features RandomFeatures(const BenchInputs& inputs, int descriptor_size, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  nn::Features features;
  features.width = inputs.width;
  features.height = inputs.height;
  features.keypoints.resize(inputs.keypoints, 2);
  features.scores.resize(inputs.keypoints);
  features.descriptors.resize(inputs.keypoints, descriptor_size);
  for (int i = 0; i < inputs.keypoints; ++i) {
    features.keypoints.row(i) << uniform(generator) * static_cast<float>(inputs.width),
        uniform(generator) * static_cast<float>(inputs.height);
    features.scores[i] = uniform(generator);
    for (int d = 0; d < descriptor_size; ++d) {
      features.descriptors(i, d) = uniform(generator) - 0.5F;
    }
    features.descriptors.row(i).normalize();
  }
  return features;
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

}  // namespace

FeaturePair ReadFeaturePair(const std::filesystem::path& path) {
  const nn::Weights file = nn::ReadWeights(path);
  return {FeaturesOf(file, "0"), FeaturesOf(file, "1")};
}

BenchWork MakeSuperPointWork(const vo::Networks& networks, const nn::SuperPointOptions& options,
                             const BenchInputs& inputs, nn::Workspace& workspace) {
  const cv::Mat image = inputs.image.empty() ? Noise(inputs.width, inputs.height)
                                             : vo::ReadGrayImage(inputs.image).pixels;
  const auto extract = [=, &workspace](nn::Features& features) {
    networks.superpoint->Extract(
        {image.data, image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step)}, options,
        workspace, features);
  };
  const auto run = [extract, features = nn::Features()]() mutable { extract(features); };
  const auto outputs = [=, &workspace] {
    nn::Weights tensors;
    nn::Features features;
    extract(features);
    AddFeatures(features, "", tensors);
    tensors.tensors["image"] = Tensor<float>({image.rows, image.cols});
    std::copy(image.begin<uchar>(), image.end<uchar>(), tensors.tensors["image"].data());

    const nn::SuperPoint::DenseMaps maps = networks.superpoint->Dense(
        {image.data, image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step)}, workspace);
    tensors.tensors["score_map"] = TensorOf(maps.scores.Matrix());
    const nn::TensorView<float> cells = maps.descriptors;
    Tensor<float> channels_first({cells.extent(2), cells.extent(0), cells.extent(1)});
    channels_first.view().Reshaped({cells.extent(2), cells.extent(0) * cells.extent(1)}).Matrix() =
        cells.Matrix().transpose();
    tensors.tensors["descriptor_map"] = std::move(channels_first);
    return tensors;
  };
  return {SizeOf(image.cols, image.rows), options.max_keypoints,
          networks.superpoint->Flops(image.cols, image.rows), run, outputs};
}

BenchWork MakeSuperGlueWork(const vo::Networks& networks, const BenchInputs& inputs,
                            nn::Workspace& workspace) {
  const int size = networks.superglue->descriptor_size();
  const auto pair = std::make_shared<const FeaturePair>(
      inputs.features.empty()
          ? FeaturePair{RandomFeatures(inputs, size, 1), RandomFeatures(inputs, size, 2)}
          : ReadFeaturePair(inputs.features));
  const auto match = [=, &workspace](nn::Matches& matches) {
    networks.superglue->Match(pair->features0, pair->features1, {}, workspace, matches);
  };
  const auto run = [match, matches = nn::Matches()]() mutable { match(matches); };
  const auto outputs = [=, &workspace] {
    nn::Weights tensors;
    nn::Matches matches;
    match(matches);
    tensors.tensors["matches0"] = TensorOfList(matches.matches0);
    tensors.tensors["matching_scores0"] = TensorOfList(matches.scores0);
    AddFeatures(pair->features0, "0", tensors);
    AddFeatures(pair->features1, "1", tensors);
    tensors.tensors["size0"] =
        TensorOfList(std::vector{pair->features0.width, pair->features0.height});
    tensors.tensors["size1"] =
        TensorOfList(std::vector{pair->features1.width, pair->features1.height});
    tensors.tensors["log_assignment"] =
        TensorOf(networks.superglue->LogAssignment(pair->features0, pair->features1, {}, workspace)
                     .Matrix());
    return tensors;
  };
  return {SizeOf(pair->features0.width, pair->features0.height), pair->features0.size(),
          networks.superglue->Flops(pair->features0.size(), pair->features1.size()), run, outputs};
}

}  // namespace gluevo::apps
