#include "gluevo/nn/random_inputs.h"

#include <algorithm>
#include <cstddef>
#include <random>

namespace gluevo::nn {

std::vector<uint8_t> RandomPixels(int width, int height) {
  std::mt19937 generator(1);
  std::vector<uint8_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::generate(pixels.begin(), pixels.end(),
                [&] { return static_cast<uint8_t>(generator() % 256); });
  return pixels;
}

Features RandomFeatures(int keypoints, int descriptor_size, int width, int height, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  Features features;
  features.width = width;
  features.height = height;
  features.keypoints.resize(keypoints, 2);
  features.scores.resize(keypoints);
  features.descriptors.resize(keypoints, descriptor_size);
  for (int i = 0; i < keypoints; ++i) {
    features.keypoints.row(i) << uniform(generator) * static_cast<float>(width),
        uniform(generator) * static_cast<float>(height);
    features.scores[i] = uniform(generator);
    for (int d = 0; d < descriptor_size; ++d) {
      features.descriptors(i, d) = uniform(generator) - 0.5F;
    }
    features.descriptors.row(i).normalize();
  }
  return features;
}

}  // namespace gluevo::nn
