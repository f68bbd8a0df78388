#include "superpoint_dialects.h"

#include <array>
#include <set>
#include <vector>

#include "batch_norm.h"
#include "reshape.h"

namespace gluevo::weights_tools {
namespace {

using nn::Shape;
using nn::Tensor;

constexpr int kLayers = 12;
constexpr std::array<const char*, kLayers> kCanonical = {"conv1a", "conv1b", "conv2a", "conv2b",
                                                         "conv3a", "conv3b", "conv4a", "conv4b",
                                                         "convPa", "convPb", "convDa", "convDb"};

// The last layers of the two heads have no ReLU.
bool HasRelu(int layer) { return layer != 9 && layer != 11; }

struct Names {
  std::string convolution;
  std::string batch_norm;
};

struct Dialect {
  std::string name;
  std::array<Names, kLayers> layers;
  bool norm_after_relu = false;
  double epsilon = kUsualEpsilon;
};

Dialect MagicLeap() {
  Dialect dialect{.name = "magic-leap"};
  for (std::size_t i = 0; i < kLayers; ++i) {
    const std::string name = kCanonical[i];
    dialect.layers[i] = {name, "bn" + name.substr(4)};
  }
  return dialect;
}

Dialect HuggingFace() {
  Dialect dialect{.name = "hugging-face"};
  for (std::size_t i = 0; i < 8; ++i) {
    const std::string block = "encoder.conv_blocks." + std::to_string(i / 2) + ".conv_";
    dialect.layers[i] = {block + (i % 2 == 0 ? "a" : "b"), ""};
  }
  dialect.layers[8] = {"keypoint_decoder.conv_score_a", ""};
  dialect.layers[9] = {"keypoint_decoder.conv_score_b", ""};
  dialect.layers[10] = {"descriptor_decoder.conv_descriptor_a", ""};
  dialect.layers[11] = {"descriptor_decoder.conv_descriptor_b", ""};
  return dialect;
}

Dialect Rpautrat() {
  Dialect dialect{.name = "rpautrat", .norm_after_relu = true, .epsilon = 1e-3};
  const auto block = [](const std::string& name) { return Names{name + ".conv", name + ".bn"}; };
  for (std::size_t i = 0; i < 8; ++i) {
    dialect.layers[i] = block("backbone." + std::to_string(i / 2) + "." + std::to_string(i % 2));
  }
  for (std::size_t i = 0; i < 2; ++i) {
    dialect.layers[8 + i] = block("detector." + std::to_string(i));
    dialect.layers[10 + i] = block("descriptor." + std::to_string(i));
  }
  return dialect;
}

Dialect PytorchSuperpoint() {
  Dialect dialect = MagicLeap();  // The heads' names are the published ones.
  dialect.name = "pytorch-superpoint";
  for (std::size_t i = 0; i < 8; ++i) {
    const std::string block =
        i < 2 ? "inc.conv.conv." : "down" + std::to_string(i / 2) + ".mpconv.1.conv.";
    const std::size_t module = i % 2 * 3;  // Convolution, batch norm, ReLU, twice.
    dialect.layers[i] = {block + std::to_string(module), block + std::to_string(module + 1)};
  }
  return dialect;
}

/// Takes tensors under their dialect's names, and remembers which.
class Translator {
 public:
  Translator(const nn::Weights& weights, const Dialect& dialect, double epsilon)
      : weights_(weights), dialect_(dialect), epsilon_(epsilon) {
    translated_.source = weights.source;
    translated_.checksum = weights.checksum;
    translated_.metadata = weights.metadata;
  }

  void TranslateLayer(int layer) {
    const Names& names = dialect_.layers[static_cast<std::size_t>(layer)];
    const std::string canonical = kCanonical[static_cast<std::size_t>(layer)];
    Tensor<float> weight = Take(names.convolution + ".weight");
    const int rank = weight.shape().rank();
    if (rank == 2) {
      weight = Reshaped(weight, Shape{weight.extent(0), weight.extent(1), 1, 1});
    } else if (rank != 4) {
      throw Error(weights_.source + ": tensor " + Quoted(names.convolution + ".weight") +
                  " has shape " + weight.shape().ToString() +
                  ", expected the weights of a convolution");
    }
    const int64_t channels = weight.extent(0);
    Tensor<float> bias(Shape{channels});
    if (weights_.Has(names.convolution + ".bias")) {
      nn::CheckShape(weights_.Get(names.convolution + ".bias").shape(), bias.shape(),
                     weights_.source + ": tensor " + Quoted(names.convolution + ".bias"));
      bias = Take(names.convolution + ".bias");
    } else if (dialect_.name == "magic-leap" && !HasBatchNorm(weights_, names.batch_norm)) {
      weights_.Get(names.convolution + ".bias");  // Says that it is missing.
    }
    if (!names.batch_norm.empty() && HasBatchNorm(weights_, names.batch_norm)) {
      const BatchNorm norm = ReadBatchNorm(weights_, names.batch_norm, channels, epsilon_);
      for (const char* part : {".weight", ".bias", ".running_mean", ".running_var"}) {
        taken_.insert(names.batch_norm + part);
      }
      if (HasRelu(layer) && dialect_.norm_after_relu) {
        Put(canonical + ".scale", norm.gain);
        Put(canonical + ".shift", norm.shift);
      } else {
        FoldIntoConvolution(norm, weight, bias);
      }
    }
    translated_.tensors.insert_or_assign(canonical + ".weight", std::move(weight));
    translated_.tensors.insert_or_assign(canonical + ".bias", std::move(bias));
  }

  /// With the tensors that nothing has taken.
  nn::Weights Finish() {
    for (const auto& [name, tensor] : weights_.tensors) {
      if (!taken_.contains(name)) {
        translated_.tensors.emplace(name, tensor);
      }
    }
    return std::move(translated_);
  }

 private:
  Tensor<float> Take(const std::string& name) {
    taken_.insert(name);
    return weights_.Get(name);
  }

  void Put(const std::string& name, const std::vector<double>& values) {
    Tensor<float> tensor(Shape{static_cast<int64_t>(values.size())});
    for (std::size_t i = 0; i < values.size(); ++i) {
      tensor[static_cast<int64_t>(i)] = static_cast<float>(values[i]);
    }
    translated_.tensors.insert_or_assign(name, std::move(tensor));
  }

  const nn::Weights& weights_;
  const Dialect& dialect_;
  double epsilon_;
  nn::Weights translated_;
  std::set<std::string> taken_;
};

}  // namespace

std::optional<TranslatedSuperPoint> TranslateSuperPoint(const nn::Weights& weights,
                                                        std::optional<double> epsilon) {
  for (const Dialect& dialect : {MagicLeap(), HuggingFace(), Rpautrat(), PytorchSuperpoint()}) {
    if (!weights.Has(dialect.layers[0].convolution + ".weight")) {
      continue;
    }
    Translator translator(weights, dialect, epsilon.value_or(dialect.epsilon));
    for (int layer = 0; layer < kLayers; ++layer) {
      translator.TranslateLayer(layer);
    }
    return TranslatedSuperPoint{translator.Finish(), dialect.name};
  }
  return std::nullopt;
}

}  // namespace gluevo::weights_tools
