#include "onnx_origins.h"

#include <set>
#include <string_view>

namespace gluevo::weights_tools {

OnnxOrigin OnnxOrigins::Of(const OnnxNode& node, std::size_t input) const {
  if (input >= node.inputs.size()) {
    return {};
  }
  const auto found = origins_.find(node.inputs[input]);
  return found == origins_.end() ? OnnxOrigin{} : found->second;
}

void OnnxOrigins::Set(const OnnxNode& node, const OnnxOrigin& origin) {
  origins_[node.outputs[0]] = origin;
}

void OnnxOrigins::SetAsOf(const OnnxNode& first, const OnnxNode& node) {
  const auto found = origins_.find(first.outputs[0]);
  if (found != origins_.end()) {
    Set(node, found->second);
  }
}

void OnnxOrigins::PassThrough(const OnnxNode& node) {
  static const std::set<std::string_view> kKeeping = {
      "Relu",    "MaxPool",   "Transpose", "Identity", "Cast", "QuantizeLinear", "DequantizeLinear",
      "Squeeze", "Unsqueeze", "Reshape",   "Dropout",  "Clip"};
  if (kKeeping.contains(node.op) && !node.inputs.empty()) {
    OnnxOrigin origin = Of(node, 0);
    origin.relu = origin.relu || node.op == "Relu" || node.op == "Clip";
    Set(node, origin);
  }
}

}  // namespace gluevo::weights_tools
