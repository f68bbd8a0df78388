#include "dialects.h"

#include <algorithm>
#include <string_view>

namespace gluevo::weights_tools {
namespace {

using nn::Shape;
using nn::Tensor;

Tensor<float> Reshaped(const Tensor<float>& tensor, const Shape& shape) {
  Tensor<float> reshaped(shape);
  std::copy_n(tensor.data(), tensor.size(), reshaped.data());
  return reshaped;
}

bool IsSuperGlueName(std::string_view name) {
  return name.starts_with("kenc.") || name.starts_with("gnn.") || name.starts_with("final_proj.");
}

}  // namespace

nn::Weights ToCanonical(nn::Weights weights) {
  for (auto& [name, tensor] : weights.tensors) {
    if (IsSuperGlueName(name) && tensor.shape().rank() == 2) {
      tensor = Reshaped(tensor, Shape{tensor.extent(0), tensor.extent(1), 1});
    } else if (name == "bin_score" && tensor.shape() == Shape{1}) {
      tensor = Reshaped(tensor, Shape{});
    }
  }
  return weights;
}

}  // namespace gluevo::weights_tools
