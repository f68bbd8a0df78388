#include "gluevo/nn/random_weights.h"

#include <cmath>
#include <initializer_list>
#include <random>
#include <string>
#include <utility>

namespace gluevo::nn {
namespace {

/// Scaled so that activations stay of the order of 1 (He et al. 2015).
class RandomWeights {
 public:
  explicit RandomWeights(unsigned seed) : generator_(seed) { weights_.source = "random weights"; }

  /// NAME.weight and NAME.bias; the first extent of `shape` is that of the outputs.
  void AddConvolution(const std::string& name, std::initializer_list<int64_t> shape,
                      double gain = 2.0) {
    const Shape weight_shape(shape);
    const int64_t outputs = weight_shape[0];
    const int64_t fan_in = weight_shape.size() / outputs;
    Fill(name + ".weight", weight_shape, std::sqrt(gain / static_cast<double>(fan_in)));
    Fill(name + ".bias", {outputs}, 0.01);
  }
  /// The identity, but for rounding.
  void AddBatchNorm(const std::string& name, int64_t size) {
    for (const char* const part : {".weight", ".bias", ".running_mean", ".running_var"}) {
      Tensor<float> tensor(Shape{size});
      const bool one = part[1] == 'w' || std::string(part) == ".running_var";
      tensor.view().Vector().setConstant(one ? 1.0F : 0.0F);
      weights_.tensors[name + part] = tensor;
    }
  }
  void Fill(const std::string& name, const Shape& shape, double deviation) {
    std::normal_distribution<float> normal(0.0F, static_cast<float>(deviation));
    Tensor<float> tensor(shape);
    for (int64_t i = 0; i < tensor.size(); ++i) {
      tensor[i] = normal(generator_);
    }
    weights_.tensors[name] = tensor;
  }
  void Put(const std::string& name, const Tensor<float>& tensor) {
    weights_.tensors[name] = tensor;
  }
  const Weights& weights() const { return weights_; }

 private:
  std::mt19937 generator_;
  Weights weights_;
};

}  // namespace

Weights RandomSuperPointWeights() {
  RandomWeights random(1);
  const char* const names[] = {"conv1a", "conv1b", "conv2a", "conv2b",
                               "conv3a", "conv3b", "conv4a", "conv4b"};
  int64_t in = 1;
  for (int i = 0; i < 8; ++i) {
    const int64_t out = i < 4 ? 64 : 128;
    random.AddConvolution(names[i], {out, in, 3, 3});
    in = out;
  }
  for (const auto& [head, out] : {std::pair<std::string, int64_t>{"convP", 65}, {"convD", 256}}) {
    random.AddConvolution(head + "a", {256, in, 3, 3});
    random.AddConvolution(head + "b", {out, 256, 1, 1});
  }
  return random.weights();
}

Weights RandomSuperGlueWeights(int layers) {
  constexpr int64_t kSize = 256;
  RandomWeights random(2);
  int64_t in = 3;
  for (int i = 0; i < 5; ++i) {
    const int64_t out = i < 3 ? 32 << i : kSize;
    const std::string prefix = "kenc.encoder.";
    random.AddConvolution(prefix + std::to_string(3 * i), {out, in, 1}, i < 4 ? 2.0 : 0.02);
    if (i < 4) {
      random.AddBatchNorm(prefix + std::to_string(3 * i + 1), out);
    }
    in = out;
  }
  for (int i = 0; i < layers; ++i) {
    const std::string prefix = "gnn.layers." + std::to_string(i) + ".";
    for (const char* const name : {"attn.proj.0", "attn.proj.1", "attn.proj.2", "attn.merge"}) {
      random.AddConvolution(prefix + name, {kSize, kSize, 1}, 1.0);
    }
    random.AddConvolution(prefix + "mlp.0", {2 * kSize, 2 * kSize, 1});
    random.AddBatchNorm(prefix + "mlp.1", 2 * kSize);
    random.AddConvolution(prefix + "mlp.3", {kSize, 2 * kSize, 1}, 0.02);
  }
  random.AddConvolution("final_proj", {kSize, kSize, 1}, 1.0);
  random.Fill("bin_score", {}, 1.0);
  return random.weights();
}

Weights RandomLightGlueWeights(int layers, int64_t descriptor_size, int64_t size, int64_t heads) {
  RandomWeights random(3);
  if (descriptor_size != size) {
    // Descriptors are of unit length.
    random.AddConvolution("input_proj", {size, descriptor_size},
                          static_cast<double>(descriptor_size));
  }
  random.Fill("posenc.Wr.weight", {size / heads / 2, 2}, 1.0);
  for (int i = 0; i < layers; ++i) {
    const std::string number = std::to_string(i);
    const std::string self = "transformers." + number + ".self_attn.";
    const std::string cross = "transformers." + number + ".cross_attn.";
    random.AddConvolution(self + "Wqkv", {3 * size, size}, 1.0);
    random.AddConvolution(self + "out_proj", {size, size}, 1.0);
    for (const char* const name : {"to_qk", "to_v", "to_out"}) {
      random.AddConvolution(cross + name, {size, size}, 1.0);
    }
    for (const std::string& block : {self, cross}) {
      random.AddConvolution(block + "ffn.0", {2 * size, 2 * size}, 1.0);
      Tensor<float> gain(Shape{2 * size});
      gain.view().Vector().setOnes();
      random.Put(block + "ffn.1.weight", gain);
      random.Fill(block + "ffn.1.bias", {2 * size}, 0.1);
      random.AddConvolution(block + "ffn.3", {size, 2 * size}, 0.1);
    }
    random.AddConvolution("log_assignment." + number + ".matchability", {1, size}, 1.0);
    random.AddConvolution("log_assignment." + number + ".final_proj", {size, size}, 1.0);
    if (i + 1 < layers) {
      random.AddConvolution("token_confidence." + number + ".token.0", {1, size}, 1.0);
    }
  }
  return random.weights();
}

Weights RandomAlikedWeights(const std::array<int64_t, 4>& widths, int64_t size, int64_t samples) {
  RandomWeights random(4);
  int64_t in = 3;
  for (int i = 0; i < 4; ++i) {
    const std::string block = "block" + std::to_string(i + 1) + ".";
    const int64_t out = widths[static_cast<std::size_t>(i)];
    for (const auto& [number, inputs] : {std::pair("1", in), {"2", out}}) {
      const std::string convolution = block + "conv" + number;
      const double deviation = 1.0 / std::sqrt(9.0 * static_cast<double>(inputs));
      random.Fill(convolution + (i >= 2 ? ".regular_conv.weight" : ".weight"), {out, inputs, 3, 3},
                  deviation);
      random.AddBatchNorm(block + "bn" + number, out);
      random.Fill(block + "bn" + number + ".bias", {out}, 0.2);
      if (i >= 2) {
        random.AddConvolution(convolution + ".offset_conv", {18, inputs, 3, 3}, 4.0);
      }
    }
    if (i > 0) {
      random.AddConvolution(block + "downsample", {out, in, 1, 1}, 1.0);
    }
    random.Fill("conv" + std::to_string(i + 1) + ".weight", {size / 4, out, 1, 1},
                1.0 / std::sqrt(static_cast<double>(out)));
    in = out;
  }
  random.Fill("score_head.0.weight", {8, size, 1, 1}, 2.0 / std::sqrt(static_cast<double>(size)));
  random.Fill("score_head.2.weight", {4, 8, 3, 3}, 0.2);
  random.Fill("score_head.4.weight", {4, 4, 3, 3}, 0.3);
  random.Fill("score_head.6.weight", {1, 4, 3, 3}, 0.3);
  random.Fill("desc_head.agg_weights", {samples, size, size},
              1.0 / std::sqrt(static_cast<double>(samples * size)));
  random.AddConvolution("desc_head.offset_conv.0", {2 * samples, size, 3, 3}, 9.0);
  random.AddConvolution("desc_head.offset_conv.2", {2 * samples, 2 * samples, 1, 1}, 16.0);
  random.Fill("desc_head.sf_conv.weight", {size, size, 1, 1}, 1.0);
  return random.weights();
}

}  // namespace gluevo::nn
