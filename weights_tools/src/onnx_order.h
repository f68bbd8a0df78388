#pragma once

#include <optional>
#include <vector>

#include "gluevo/nn/weights.h"
#include "onnx_modules.h"

namespace gluevo::weights_tools {

/// Names by order and shape, for exports that lost the names of their tensors (torch.onnx.export
/// names what it folds onnx::Conv_123). Fills `weights` with a SuperPoint under the published names
/// (rpautrat's, where batch norms follow the ReLUs) or with a SuperGlue under the published ones.
/// False where the linear maps are those of neither.
bool NameByOrder(const std::vector<OnnxLinear>& linears, nn::Weights& weights);

}  // namespace gluevo::weights_tools
