#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "gluevo/nn/weights.h"

// Networks of a few channels with random weights, under the published names.

namespace gluevo::weights_tools {

/// Values of the size that keeps a layer's outputs near its inputs.
inline nn::Tensor<float> RandomTensor(const nn::Shape& shape, std::mt19937& random,
                                      float least = -1, float most = 1) {
  nn::Tensor<float> tensor(shape);
  for (int64_t i = 0; i < tensor.size(); ++i) {
    const float unit = static_cast<float>(random() >> 8) * 0x1p-24F;
    tensor[i] = least + (most - least) * unit;
  }
  return tensor;
}

inline void AddConvolution(nn::Weights& weights, const std::string& name, const nn::Shape& shape,
                           std::mt19937& random) {
  const int64_t inputs = shape.size() / shape[0];
  const float size = std::sqrt(6.0F / static_cast<float>(inputs));
  weights.tensors.emplace(name + ".weight", RandomTensor(shape, random, -size, size));
  weights.tensors.emplace(name + ".bias", RandomTensor(nn::Shape{shape[0]}, random, -0.1F, 0.1F));
}

inline void AddBatchNorm(nn::Weights& weights, const std::string& name, int64_t channels,
                         std::mt19937& random) {
  const nn::Shape shape{channels};
  weights.tensors.emplace(name + ".weight", RandomTensor(shape, random, 0.5F, 1.5F));
  weights.tensors.emplace(name + ".bias", RandomTensor(shape, random, -0.2F, 0.2F));
  weights.tensors.emplace(name + ".running_mean", RandomTensor(shape, random, -0.2F, 0.2F));
  weights.tensors.emplace(name + ".running_var", RandomTensor(shape, random, 0.5F, 1.5F));
}

inline nn::Weights SmallSuperPoint(uint32_t seed = 1) {
  nn::Weights weights;
  std::mt19937 random(seed);
  constexpr std::array<const char*, 8> kNames = {"conv1a", "conv1b", "conv2a", "conv2b",
                                                 "conv3a", "conv3b", "conv4a", "conv4b"};
  constexpr std::array<int64_t, 8> kWidths = {4, 4, 4, 6, 6, 8, 8, 8};
  int64_t channels = 1;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    AddConvolution(weights, kNames[i], nn::Shape{kWidths[i], channels, 3, 3}, random);
    channels = kWidths[i];
  }
  AddConvolution(weights, "convPa", nn::Shape{10, channels, 3, 3}, random);
  AddConvolution(weights, "convPb", nn::Shape{65, 10, 1, 1}, random);
  AddConvolution(weights, "convDa", nn::Shape{12, channels, 3, 3}, random);
  AddConvolution(weights, "convDb", nn::Shape{16, 12, 1, 1}, random);
  return weights;
}

inline nn::Weights SmallSuperGlue(uint32_t seed = 2, int64_t size = 16, int layers = 2) {
  nn::Weights weights;
  std::mt19937 random(seed);
  AddConvolution(weights, "kenc.encoder.0", nn::Shape{8, 3, 1}, random);
  AddBatchNorm(weights, "kenc.encoder.1", 8, random);
  AddConvolution(weights, "kenc.encoder.3", nn::Shape{size, 8, 1}, random);
  for (int i = 0; i < layers; ++i) {
    const std::string layer = "gnn.layers." + std::to_string(i) + ".";
    for (const char* name : {"attn.proj.0", "attn.proj.1", "attn.proj.2", "attn.merge"}) {
      AddConvolution(weights, layer + name, nn::Shape{size, size, 1}, random);
    }
    AddConvolution(weights, layer + "mlp.0", nn::Shape{2 * size, 2 * size, 1}, random);
    AddBatchNorm(weights, layer + "mlp.1", 2 * size, random);
    AddConvolution(weights, layer + "mlp.3", nn::Shape{size, 2 * size, 1}, random);
  }
  AddConvolution(weights, "final_proj", nn::Shape{size, size, 1}, random);
  weights.tensors.emplace("bin_score", RandomTensor(nn::Shape{}, random, 0.5F, 1.5F));
  return weights;
}

}  // namespace gluevo::weights_tools
