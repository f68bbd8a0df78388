#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "gluevo/nn/tensor.h"
#include "kernels/reference.h"
#include "kernels/vectorized.h"

// What the kernels' tests share. A sum of n products in floats errs by at most gamma_n times the
// sum of their absolute values, gamma_n = n u / (1 - n u), u = 2^-24 (Higham 2002, section 3.1), in
// whatever order and with or without fused multiply-adds: the bound of each output comes from a
// run on absolute values.
namespace gluevo::nn::kernels {

inline constexpr double kUnit = 0x1p-24;
// Outside of what a kernel may write.
inline constexpr float kGuard = 1234.5F;

inline double Gamma(int64_t n) {
  return static_cast<double>(n) * kUnit / (1.0 - static_cast<double>(n) * kUnit);
}

inline std::vector<const Kernels*> AllSets() {
  std::vector<const Kernels*> sets = VectorizedKernels();
  sets.push_back(&ScalarKernels());
  return sets;
}

inline Tensor<float> Random(int64_t size, float low = -1.0F, float high = 1.0F) {
  static std::mt19937 generator(7);
  Tensor<float> tensor(Shape{size});
  std::uniform_real_distribution<float> uniform(low, high);
  std::generate_n(tensor.data(), size, [&] { return uniform(generator); });
  return tensor;
}

inline Tensor<float> Filled(int64_t size, float value) {
  Tensor<float> tensor(Shape{size});
  std::fill_n(tensor.data(), size, value);
  return tensor;
}

inline Tensor<float> Absolute(const Tensor<float>& tensor) {
  Tensor<float> result(tensor.shape());
  result.view().Vector() = tensor.view().Vector().cwiseAbs();
  return result;
}

}  // namespace gluevo::nn::kernels
