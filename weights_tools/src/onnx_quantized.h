#pragma once

#include "onnx_model.h"

namespace gluevo::weights_tools {

/// Replaces the operators that compute on quantised numbers (QLinearConv and QLinearMatMul of ONNX,
/// QLinearAdd and QGemm of ONNX Runtime) by DequantizeLinear and Conv, MatMul, Add or Gemm, which
/// mean the same up to rounding. A ReLU that became a part of an output's quantisation comes back.
void UnfoldQuantizedOperators(OnnxModel& model);

}  // namespace gluevo::weights_tools
