#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "gluevo/nn/weights.h"

// SuperPoint from the canonical tensors in the plainest loops, in double: what converted weights
// mean, whatever the runtime makes of them.

namespace gluevo::weights_tools {

struct PlainMap {
  int64_t channels = 0;
  int64_t height = 0;
  int64_t width = 0;
  std::vector<double> values;

  double& at(int64_t c, int64_t y, int64_t x) {
    return values[static_cast<std::size_t>((c * height + y) * width + x)];
  }
  double padded(int64_t c, int64_t y, int64_t x) const {
    const bool inside = y >= 0 && y < height && x >= 0 && x < width;
    return inside ? values[static_cast<std::size_t>((c * height + y) * width + x)] : 0.0;
  }
};

inline PlainMap PlainConvolution(const nn::Weights& weights, const std::string& name,
                                 const PlainMap& in, bool relu) {
  const nn::Tensor<float>& weight = weights.Get(name + ".weight");
  const nn::Tensor<float>& bias = weights.Get(name + ".bias");
  const int64_t kernel = weight.extent(2);
  PlainMap out{weight.extent(0), in.height, in.width, {}};
  out.values.resize(static_cast<std::size_t>(out.channels * out.height * out.width));
  for (int64_t c = 0; c < out.channels; ++c) {
    for (int64_t y = 0; y < out.height; ++y) {
      for (int64_t x = 0; x < out.width; ++x) {
        double sum = bias[c];
        for (int64_t k = 0; k < in.channels; ++k) {
          for (int64_t i = 0; i < kernel; ++i) {
            for (int64_t j = 0; j < kernel; ++j) {
              sum += weight[((c * in.channels + k) * kernel + i) * kernel + j] *
                     in.padded(k, y + i - kernel / 2, x + j - kernel / 2);
            }
          }
        }
        sum = relu ? std::max(sum, 0.0) : sum;
        if (weights.Has(name + ".scale")) {
          sum = sum * weights.Get(name + ".scale")[c] + weights.Get(name + ".shift")[c];
        }
        out.at(c, y, x) = sum;
      }
    }
  }
  return out;
}

inline PlainMap PlainMaxPool(const PlainMap& in) {
  PlainMap out{in.channels, in.height / 2, in.width / 2, {}};
  out.values.resize(static_cast<std::size_t>(out.channels * out.height * out.width));
  for (int64_t c = 0; c < out.channels; ++c) {
    for (int64_t y = 0; y < out.height; ++y) {
      for (int64_t x = 0; x < out.width; ++x) {
        out.at(c, y, x) =
            std::max(std::max(in.padded(c, 2 * y, 2 * x), in.padded(c, 2 * y, 2 * x + 1)),
                     std::max(in.padded(c, 2 * y + 1, 2 * x), in.padded(c, 2 * y + 1, 2 * x + 1)));
      }
    }
  }
  return out;
}

struct PlainOutputs {
  Eigen::MatrixXd scores;       // [8 h x 8 w]
  Eigen::MatrixXd descriptors;  // [h w x D], unit rows
};

/// Of an image [height x width] of gray levels 0 to 255.
inline PlainOutputs PlainSuperPoint(const nn::Weights& weights, const nn::Tensor<float>& image) {
  PlainMap map{1, image.extent(0), image.extent(1), {}};
  for (int64_t i = 0; i < image.size(); ++i) {
    map.values.push_back(image[i] / 255.0);
  }
  for (const char* layer : {"1a", "1b", "2a", "2b", "3a", "3b", "4a", "4b"}) {
    map = PlainConvolution(weights, std::string("conv") + layer, map, true);
    if (layer[1] == 'b' && layer[0] != '4') {
      map = PlainMaxPool(map);
    }
  }
  PlainMap logits =
      PlainConvolution(weights, "convPb", PlainConvolution(weights, "convPa", map, true), false);
  PlainMap descriptors =
      PlainConvolution(weights, "convDb", PlainConvolution(weights, "convDa", map, true), false);

  PlainOutputs outputs;
  outputs.scores.resize(8 * map.height, 8 * map.width);
  outputs.descriptors.resize(map.height * map.width, descriptors.channels);
  for (int64_t y = 0; y < map.height; ++y) {
    for (int64_t x = 0; x < map.width; ++x) {
      double sum = 0;
      for (int64_t c = 0; c < logits.channels; ++c) {
        sum += std::exp(logits.at(c, y, x));
      }
      for (int64_t c = 0; c < 64; ++c) {
        outputs.scores(8 * y + c / 8, 8 * x + c % 8) = std::exp(logits.at(c, y, x)) / sum;
      }
      auto row = outputs.descriptors.row(y * map.width + x);
      for (int64_t c = 0; c < descriptors.channels; ++c) {
        row[c] = descriptors.at(c, y, x);
      }
      row.normalize();
    }
  }
  return outputs;
}

}  // namespace gluevo::weights_tools
