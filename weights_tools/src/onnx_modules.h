#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gluevo/nn/tensor.h"
#include "onnx_constants.h"
#include "onnx_model.h"

namespace gluevo::weights_tools {

/// A batch norm of the graph, as its four tensors.
struct OnnxBatchNorm {
  std::string name;  ///< Of its module, empty where no tensor tells.
  nn::Tensor<float> weight, bias, mean, variance;
  double epsilon = 1e-5;
  bool after_relu = false;
};

/// A convolution or a matrix with the weights of the file, once however often it is used.
struct OnnxLinear {
  std::string name;          ///< Of its module, empty where no tensor tells.
  nn::Tensor<float> weight;  ///< [out x in], [out x in x 1] or [out x in x k x k]
  std::optional<nn::Tensor<float>> bias;
  std::optional<OnnxBatchNorm> norm;  ///< What follows it.
  const OnnxNode* node = nullptr;     ///< Its first use.
  /// Index of the linear whose output reaches it through ReLU, batch norm, pooling and the like
  /// alone; -1 where there is none.
  int input = -1;
};

/// The linear maps of the graph in the order of their first use. Conv, Gemm, and MatMul with or
/// without an Add. Throws Error for convolutions that do not keep the size of their input, for
/// operators of other kinds with weights (ConvInteger, ...), and for batch norms that belong to
/// none.
std::vector<OnnxLinear> FindLinears(const OnnxModel& model, const OnnxConstants& constants);

}  // namespace gluevo::weights_tools
