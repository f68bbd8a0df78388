// Describes two points of an image. Exit code 0 where their descriptors are of unit length.

#include <gluevo/nn/superpoint.h>

#include <cmath>
#include <cstdint>
#include <iostream>
#include <vector>

int main() {
  constexpr int kSide = 64;
  std::vector<uint8_t> pixels(kSide * kSide);
  for (int i = 0; i < kSide * kSide; ++i) {
    pixels[static_cast<std::size_t>(i)] = static_cast<uint8_t>(i * i * 37);
  }
  gluevo::nn::ThreadPool pool(1);
  gluevo::nn::Workspace workspace(pool);
  gluevo::nn::Features features;
  features.keypoints.resize(2, 2);
  features.keypoints << 20.0F, 30.0F, 40.0F, 50.0F;
  gluevo::nn::SuperPoint(gluevo::nn::OpenSuperPointWeights())
      .Describe({pixels.data(), kSide, kSide, kSide}, workspace, features);
  std::cout << features.descriptors.rows() << " descriptors\n";
  return std::abs(features.descriptors.norm() - std::sqrt(2.0F)) < 1e-4F ? 0 : 1;
}
