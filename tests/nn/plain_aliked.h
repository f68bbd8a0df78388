#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "gluevo/nn/features.h"
#include "gluevo/nn/gray_image.h"
#include "gluevo/nn/weights.h"

// ALIKED once more, as its paper and its published weights have it: in double, straight from the
// tensors, with three colours, the whole feature map, and nothing folded.
namespace gluevo::nn {

/// Channels x rows x columns.
struct PlainMap {
  PlainMap() = default;
  PlainMap(int channels_in, int height_in, int width_in)
      : channels(channels_in),
        height(height_in),
        width(width_in),
        values(static_cast<std::size_t>(channels_in) * height_in * width_in) {}
  double& at(int c, int y, int x) {
    return values[(static_cast<std::size_t>(c) * height + y) * width + x];
  }
  double at(int c, int y, int x) const {
    return values[(static_cast<std::size_t>(c) * height + y) * width + x];
  }
  /// Bilinear, zeros outside.
  double Sample(int c, double y, double x) const {
    const double top = std::floor(y);
    const double left = std::floor(x);
    double sum = 0.0;
    for (int i = 0; i < 4; ++i) {
      const double v = top + i / 2;
      const double u = left + i % 2;
      if (v >= 0 && v < height && u >= 0 && u < width) {
        sum += (1.0 - std::abs(y - v)) * (1.0 - std::abs(x - u)) *
               at(c, static_cast<int>(v), static_cast<int>(u));
      }
    }
    return sum;
  }

  int channels = 0;
  int height = 0;
  int width = 0;
  std::vector<double> values;
};

class PlainAliked {
 public:
  PlainAliked(const Weights& weights, const GrayImage& image) : weights_(weights) {
    const int pad_x = (32 - image.width % 32) % 32;
    const int pad_y = (32 - image.height % 32) % 32;
    const int left = pad_x / 2;
    const int top = pad_y / 2;
    PlainMap x(3, image.height + pad_y, image.width + pad_x);
    for (int c = 0; c < 3; ++c) {
      for (int v = 0; v < x.height; ++v) {
        for (int u = 0; u < x.width; ++u) {
          x.at(c, v, u) = image.data[std::clamp(v - top, 0, image.height - 1) * image.stride +
                                     std::clamp(u - left, 0, image.width - 1)] /
                          255.0;
        }
      }
    }
    x = Selu(Norm("block1.bn1", Convolve("block1.conv1", x)));
    blocks.push_back(Selu(Norm("block1.bn2", Convolve("block1.conv2", x))));
    blocks.push_back(Residual("block2.", Pool(blocks[0], 2), false));
    blocks.push_back(Residual("block3.", Pool(blocks[1], 4), true));
    blocks.push_back(Residual("block4.", Pool(blocks[2], 4), true));
    const int size = 4 * static_cast<int>(weights.Get("conv1.weight").extent(0));
    PlainMap all(size, blocks[0].height, blocks[0].width);
    for (int i = 0; i < 4; ++i) {
      const PlainMap part = Upsample(Selu(Convolve("conv" + std::to_string(i + 1), blocks[i])),
                                     all.height, all.width);
      std::copy(part.values.begin(), part.values.end(),
                all.values.begin() + static_cast<std::ptrdiff_t>(i * part.values.size()));
    }
    PlainMap s = Selu(Convolve("score_head.0", all));
    s = Selu(Convolve("score_head.2", s));
    s = Selu(Convolve("score_head.4", s));
    s = Convolve("score_head.6", s);
    for (double& value : s.values) {
      value = 1.0 / (1.0 + std::exp(-value));
    }
    for (int v = 0; v < all.height; ++v) {
      for (int u = 0; u < all.width; ++u) {
        double squares = 0.0;
        for (int c = 0; c < size; ++c) {
          squares += all.at(c, v, u) * all.at(c, v, u);
        }
        for (int c = 0; c < size; ++c) {
          all.at(c, v, u) /= std::max(std::sqrt(squares), 1e-12);
        }
      }
    }
    scores = Crop(s, top, left, image.height, image.width);
    features = Crop(all, top, left, image.height, image.width);
  }

  /// Of one position, in pixels.
  std::vector<double> Describe(double x, double y) const {
    const int size = features.channels;
    const Tensor<float>& aggregation = weights_.Get("desc_head.agg_weights");
    const int samples = static_cast<int>(aggregation.extent(0));
    const int first_x = std::min(std::max(static_cast<int>(x) - 1, 0), features.width - 4);
    const int first_y = std::min(std::max(static_cast<int>(y) - 1, 0), features.height - 4);
    const PlainMap patch = Crop(features, first_y, first_x, 3, 3);
    // Of the convolution of the patch only its middle is without padding.
    PlainMap middle(2 * samples, 1, 1);
    const PlainMap hidden = Convolve("desc_head.offset_conv.0", patch);
    for (int c = 0; c < 2 * samples; ++c) {
      middle.at(c, 0, 0) = hidden.at(c, 1, 1);
    }
    const PlainMap offsets = Convolve("desc_head.offset_conv.2", Selu(middle));
    const double limit = std::max(features.width, features.height) / 4.0;
    std::vector<double> descriptor(static_cast<std::size_t>(size));
    for (int p = 0; p < samples; ++p) {
      const double u = x + std::clamp(offsets.at(p, 0, 0), -limit, limit);
      const double v = y + std::clamp(offsets.at(samples + p, 0, 0), -limit, limit);
      PlainMap sampled(size, 1, 1);
      for (int c = 0; c < size; ++c) {
        sampled.at(c, 0, 0) = features.Sample(c, v, u);
      }
      const PlainMap activated = Selu(Convolve("desc_head.sf_conv", sampled));
      for (int c = 0; c < size; ++c) {
        for (int j = 0; j < size; ++j) {
          descriptor[static_cast<std::size_t>(j)] +=
              activated.at(c, 0, 0) * aggregation[(int64_t{p} * size + c) * size + j];
        }
      }
    }
    double squares = 0.0;
    for (const double value : descriptor) {
      squares += value * value;
    }
    for (double& value : descriptor) {
      value /= std::sqrt(squares);
    }
    return descriptor;
  }

  std::vector<PlainMap> blocks;
  PlainMap scores;
  PlainMap features;

 private:
  static PlainMap Selu(PlainMap map) {
    for (double& x : map.values) {
      x = 1.0507009873554805 * (x > 0.0 ? x : 1.6732632423543772 * (std::exp(x) - 1.0));
    }
    return map;
  }
  static PlainMap Crop(const PlainMap& map, int top, int left, int height, int width) {
    PlainMap result(map.channels, height, width);
    for (int c = 0; c < map.channels; ++c) {
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          result.at(c, y, x) = map.at(c, top + y, left + x);
        }
      }
    }
    return result;
  }
  static PlainMap Pool(const PlainMap& map, int size) {
    PlainMap result(map.channels, map.height / size, map.width / size);
    for (int c = 0; c < map.channels; ++c) {
      for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
          result.at(c, y / size, x / size) += map.at(c, y, x) / (size * size);
        }
      }
    }
    return result;
  }
  // Corners aligned.
  static PlainMap Upsample(const PlainMap& map, int height, int width) {
    PlainMap result(map.channels, height, width);
    for (int y = 0; y < height; ++y) {
      const double v = height > 1 ? static_cast<double>(y) * (map.height - 1) / (height - 1) : 0.0;
      for (int x = 0; x < width; ++x) {
        const double u = width > 1 ? static_cast<double>(x) * (map.width - 1) / (width - 1) : 0.0;
        for (int c = 0; c < map.channels; ++c) {
          result.at(c, y, x) = map.Sample(c, v, u);
        }
      }
    }
    return result;
  }

  PlainMap Norm(const std::string& name, PlainMap map) const {
    for (int c = 0; c < map.channels; ++c) {
      const double gain = weights_.Get(name + ".weight")[c] /
                          std::sqrt(weights_.Get(name + ".running_var")[c] + 1e-5);
      for (int i = 0; i < map.height * map.width; ++i) {
        double& x = map.at(c, i / map.width, i % map.width);
        x = (x - weights_.Get(name + ".running_mean")[c]) * gain + weights_.Get(name + ".bias")[c];
      }
    }
    return map;
  }
  // Of 3x3 with padding or 1x1, with a bias where there is one; with offsets deformable.
  PlainMap Convolve(const std::string& name, const PlainMap& in,
                    const PlainMap* offsets = nullptr) const {
    const Tensor<float>& weight = weights_.Get(name + ".weight");
    const int side = static_cast<int>(weight.extent(2));
    const double limit = std::max(in.height, in.width) / 4.0;
    PlainMap out(static_cast<int>(weight.extent(0)), in.height, in.width);
    for (int y = 0; y < in.height; ++y) {
      for (int x = 0; x < in.width; ++x) {
        for (int tap = 0; tap < side * side; ++tap) {
          double v = y + tap / side - side / 2;
          double u = x + tap % side - side / 2;
          if (offsets != nullptr) {
            v += std::clamp(offsets->at(2 * tap, y, x), -limit, limit);
            u += std::clamp(offsets->at(2 * tap + 1, y, x), -limit, limit);
          }
          for (int c = 0; c < in.channels; ++c) {
            const double value = in.Sample(c, v, u);
            for (int o = 0; o < out.channels; ++o) {
              out.at(o, y, x) +=
                  value * weight[((int64_t{o} * in.channels + c) * side * side) + tap];
            }
          }
        }
      }
    }
    if (weights_.Has(name + ".bias")) {
      for (int o = 0; o < out.channels; ++o) {
        for (int i = 0; i < out.height * out.width; ++i) {
          out.at(o, i / out.width, i % out.width) += weights_.Get(name + ".bias")[o];
        }
      }
    }
    return out;
  }
  PlainMap Convolve3x3(const std::string& name, const PlainMap& in, bool deformable) const {
    if (!deformable) {
      return Convolve(name, in);
    }
    const PlainMap offsets = Convolve(name + ".offset_conv", in);
    return Convolve(name + ".regular_conv", in, &offsets);
  }
  PlainMap Residual(const std::string& block, const PlainMap& in, bool deformable) const {
    const PlainMap inner = Selu(Norm(block + "bn1", Convolve3x3(block + "conv1", in, deformable)));
    PlainMap out = Norm(block + "bn2", Convolve3x3(block + "conv2", inner, deformable));
    const PlainMap shortcut = Convolve(block + "downsample", in);
    for (std::size_t i = 0; i < out.values.size(); ++i) {
      out.values[i] += shortcut.values[i];
    }
    return Selu(out);
  }

  const Weights& weights_;
};

}  // namespace gluevo::nn
