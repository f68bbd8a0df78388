#pragma once

#include <algorithm>

#include "gluevo/nn/tensor.h"

namespace gluevo::weights_tools {

/// The same elements under another shape of the same size.
inline nn::Tensor<float> Reshaped(const nn::Tensor<float>& tensor, const nn::Shape& shape) {
  nn::CheckShape(nn::Shape{shape.size()}, nn::Shape{tensor.size()}, "reshaped tensor");
  nn::Tensor<float> reshaped(shape);
  std::copy_n(tensor.data(), tensor.size(), reshaped.data());
  return reshaped;
}

}  // namespace gluevo::weights_tools
