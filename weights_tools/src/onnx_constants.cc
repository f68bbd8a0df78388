#include "onnx_constants.h"

#include <set>
#include <string_view>
#include <utility>

#include "reshape.h"

namespace gluevo::weights_tools {
namespace {

using nn::Shape;
using nn::Tensor;

// Exporters put two or three nodes between a tensor and its use.
constexpr int kDeepest = 8;
// SuperGlue runs every layer twice, once for each image.
constexpr uint64_t kFreeValues = uint64_t{1} << 24;
constexpr uint64_t kUses = 8;

}  // namespace

Tensor<float> Transposed(const Tensor<float>& matrix) {
  const int64_t rows = matrix.extent(0);
  const int64_t columns = matrix.extent(1);
  Tensor<float> transposed(Shape{columns, rows});
  for (int64_t i = 0; i < rows; ++i) {
    for (int64_t j = 0; j < columns; ++j) {
      transposed[j * rows + i] = matrix[i * columns + j];
    }
  }
  return transposed;
}

OnnxConstants::OnnxConstants(const OnnxModel& model, uint64_t file_size)
    : model_(model), budget_(kFreeValues + kUses * file_size) {
  for (const OnnxNode& node : model.nodes) {
    for (const std::string& output : node.outputs) {
      if (!output.empty() && !producers_.emplace(output, &node).second) {
        node.message.Fail(0, "the value " + Quoted(output) + " of the ONNX model is made twice");
      }
    }
    for (const std::string& input : std::set(node.inputs.begin(), node.inputs.end())) {
      consumers_.emplace(input, &node);
    }
  }
}

const OnnxNode* OnnxConstants::ProducerOf(const std::string& name) const {
  const auto found = producers_.find(name);
  return found == producers_.end() ? nullptr : found->second;
}

std::vector<const OnnxNode*> OnnxConstants::ConsumersOf(const std::string& name) const {
  std::vector<const OnnxNode*> consumers;
  const auto [begin, end] = consumers_.equal_range(name);
  for (auto it = begin; it != end; ++it) {
    consumers.push_back(it->second);
  }
  return consumers;
}

std::optional<OnnxConstant> OnnxConstants::Get(const std::string& name) const {
  return Get(name, 0);
}

std::optional<OnnxConstant> OnnxConstants::AddedBehind(const OnnxNode& node, int64_t count) const {
  static const std::set<std::string_view> kKeeping = {"QuantizeLinear", "DequantizeLinear",
                                                      "Identity", "Cast"};
  std::string value = node.outputs[0];
  for (int depth = 0; depth < kDeepest; ++depth) {
    const OnnxNode* next = nullptr;
    for (const OnnxNode* consumer : ConsumersOf(value)) {
      if (consumer->op == "Add" && consumer->inputs.size() == 2) {
        for (const std::string& name : consumer->inputs) {
          std::optional<OnnxConstant> added = Get(name);
          if (added && added->values.size() == count) {
            added->values = Reshaped(added->values, Shape{count});
            return added;
          }
        }
      }
      if (kKeeping.contains(consumer->op) && consumer->inputs[0] == value &&
          !consumer->outputs.empty()) {
        next = consumer;
      }
    }
    if (next == nullptr) {
      return std::nullopt;
    }
    value = next->outputs[0];
  }
  return std::nullopt;
}

std::optional<OnnxConstant> OnnxConstants::Get(const std::string& name, int depth) const {
  const auto found = model_.tensors.find(name);
  if (found != model_.tensors.end()) {
    OnnxConstant constant{OnnxValues(found->second), name};
    const auto size = static_cast<uint64_t>(constant.values.size()) + 1;
    if (size > budget_) {
      found->second.message.Fail(0,
                                 "the model uses its tensors too often, such as " + Quoted(name));
    }
    budget_ -= size;
    return constant;
  }
  const OnnxNode* node = ProducerOf(name);
  if (node == nullptr || node->inputs.empty() || depth == kDeepest) {
    return std::nullopt;
  }
  if (node->op == "Identity" || node->op == "Cast") {
    return Get(node->inputs[0], depth + 1);
  }
  if (node->op == "DequantizeLinear" && depth + 1 < kDeepest) {
    return Dequantize(*node, depth + 1);
  }
  if (node->op == "Transpose") {
    std::optional<OnnxConstant> constant = Get(node->inputs[0], depth + 1);
    const auto order = node->attributes.find("perm");
    const bool exchanged =
        order == node->attributes.end() || order->second.integers == std::vector<int64_t>{1, 0};
    if (constant && constant->values.shape().rank() == 2) {
      if (exchanged) {
        constant->values = Transposed(constant->values);
      }
      return constant;
    }
  }
  return std::nullopt;
}

std::optional<OnnxConstant> OnnxConstants::Dequantize(const OnnxNode& node, int depth) const {
  std::optional<OnnxConstant> constant = Get(node.inputs[0], depth);
  if (!constant || node.inputs.size() < 2) {
    return std::nullopt;
  }
  // Tensors of the file, or such behind one node: three ways at every depth would be too many.
  const std::optional<OnnxConstant> scale = Get(node.inputs[1], kDeepest - 1);
  const bool has_zero = node.inputs.size() > 2 && !node.inputs[2].empty();
  const std::optional<OnnxConstant> zero =
      has_zero ? Get(node.inputs[2], kDeepest - 1) : std::nullopt;
  if (!scale || (has_zero && !zero)) {
    return std::nullopt;
  }
  Tensor<float>& values = constant->values;
  const Shape& shape = values.shape();
  int64_t axis = node.Integer("axis", 1);
  axis += axis < 0 ? shape.rank() : 0;
  const int64_t count = scale->values.size();
  const bool fits =
      count == 1 || (axis >= 0 && axis < shape.rank() && count == shape[static_cast<int>(axis)]);
  if (!fits || (zero && zero->values.size() != count)) {
    node.message.Fail(0, "the scales of " + Quoted(constant->root) + ", " + std::to_string(count) +
                             ", do not fit its shape " + shape.ToString());
  }
  int64_t inner = 1;  // Elements that share a scale.
  for (int i = static_cast<int>(axis) + 1; count > 1 && i < shape.rank(); ++i) {
    inner *= shape[i];
  }
  for (int64_t i = 0; i < values.size(); ++i) {
    const int64_t at = count == 1 ? 0 : i / inner % count;
    values[i] = (values[i] - (zero ? zero->values[at] : 0.0F)) * scale->values[at];
  }
  return constant;
}

}  // namespace gluevo::weights_tools
