#include "batch_norm.h"

#include <algorithm>
#include <cmath>

namespace gluevo::weights_tools {
namespace {

using nn::Shape;
using nn::Tensor;

const Tensor<float>& Variances(const nn::Weights& weights, const std::string& name,
                               const Shape& shape) {
  const Tensor<float>& variances = weights.Get(name + ".running_var", shape);
  for (int64_t i = 0; i < variances.size(); ++i) {
    if (variances[i] < 0) {
      throw Error(weights.source + ": tensor " + Quoted(name + ".running_var") +
                  " holds a negative variance at index " + std::to_string(i));
    }
  }
  return variances;
}

}  // namespace

bool HasBatchNorm(const nn::Weights& weights, const std::string& name) {
  return weights.Has(name + ".running_mean");
}

BatchNorm ReadBatchNorm(const nn::Weights& weights, const std::string& name, int64_t channels,
                        double epsilon) {
  const Shape shape{channels};
  const Tensor<float>& weight = weights.Get(name + ".weight", shape);
  const Tensor<float>& bias = weights.Get(name + ".bias", shape);
  const Tensor<float>& mean = weights.Get(name + ".running_mean", shape);
  const Tensor<float>& variance = Variances(weights, name, shape);
  BatchNorm norm;
  for (int64_t i = 0; i < channels; ++i) {
    const double gain = weight[i] / std::sqrt(variance[i] + epsilon);
    norm.gain.push_back(gain);
    norm.shift.push_back(bias[i] - gain * mean[i]);
  }
  return norm;
}

void FoldIntoConvolution(const BatchNorm& norm, Tensor<float>& weight, Tensor<float>& bias) {
  const int64_t row = bias.size() == 0 ? 0 : weight.size() / bias.size();
  for (int64_t i = 0; i < bias.size(); ++i) {
    const double gain = norm.gain[static_cast<std::size_t>(i)];
    for (int64_t j = i * row; j < (i + 1) * row; ++j) {
      weight[j] = static_cast<float>(gain * weight[j]);
    }
    bias[i] = static_cast<float>(gain * bias[i] + norm.shift[static_cast<std::size_t>(i)]);
  }
}

void AddIdentityBatchNorm(nn::Weights& weights, const std::string& name, int64_t channels) {
  const auto add = [&](const char* part, double value) {
    Tensor<float> tensor(Shape{channels});
    std::fill_n(tensor.data(), channels, static_cast<float>(value));
    weights.tensors.insert_or_assign(name + part, std::move(tensor));
  };
  add(".weight", 1);
  add(".bias", 0);
  add(".running_mean", 0);
  add(".running_var", 1 - kUsualEpsilon);
}

void UseUsualEpsilon(nn::Weights& weights, const std::string& name, double epsilon) {
  if (epsilon == kUsualEpsilon || !HasBatchNorm(weights, name)) {
    return;
  }
  Tensor<float>& weight = weights.tensors.at(name + ".weight");
  const Tensor<float>& variance = Variances(weights, name, weight.shape());
  for (int64_t i = 0; i < weight.size(); ++i) {
    weight[i] = static_cast<float>(
        weight[i] * std::sqrt((variance[i] + kUsualEpsilon) / (variance[i] + epsilon)));
  }
}

}  // namespace gluevo::weights_tools
