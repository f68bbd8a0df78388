#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/nn/tensor.h"
#include "onnx_model.h"

namespace gluevo::weights_tools {

/// A value of the graph that depends on no input, and the tensor of the file that it comes from.
struct OnnxConstant {
  nn::Tensor<float> values;
  std::string root;
};

/// Evaluates what lies between a model's tensors and the nodes that use them as weights: Identity,
/// Cast, Transpose and DequantizeLinear. Each evaluation costs time, so that all together may make
/// no more values than weights of this file can need.
class OnnxConstants {
 public:
  /// `file_size` in bytes sets that limit.
  OnnxConstants(const OnnxModel& model, uint64_t file_size);

  /// Nothing for a value that is no constant, or is made of a constant in another way. Throws Error
  /// where the tensor cannot be read.
  std::optional<OnnxConstant> Get(const std::string& name) const;

  /// The constant of `count` values that an Add behind this node adds to its output, quantised or
  /// cast between them or not: the bias of whatever the node computes.
  std::optional<OnnxConstant> AddedBehind(const OnnxNode& node, int64_t count) const;

  /// The node that makes this value, or null.
  const OnnxNode* ProducerOf(const std::string& name) const;
  /// The nodes that take this value, in their order.
  std::vector<const OnnxNode*> ConsumersOf(const std::string& name) const;

 private:
  std::optional<OnnxConstant> Get(const std::string& name, int depth) const;
  std::optional<OnnxConstant> Dequantize(const OnnxNode& node, int depth) const;

  const OnnxModel& model_;
  mutable uint64_t budget_;  // Values that may still be made.
  std::map<std::string, const OnnxNode*> producers_;
  std::multimap<std::string, const OnnxNode*> consumers_;
};

/// Rows and columns of a matrix exchanged.
nn::Tensor<float> Transposed(const nn::Tensor<float>& matrix);

}  // namespace gluevo::weights_tools
