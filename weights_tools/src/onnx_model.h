#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/nn/bytes.h"
#include "gluevo/nn/tensor.h"

namespace gluevo::weights_tools {

/// ONNX's TensorProto, not converted yet.
struct OnnxTensor {
  nn::Bytes message;  ///< For messages.
  std::string name;
  std::vector<uint64_t> dims;
  uint64_t type = 0;                ///< TensorProto.DataType.
  std::optional<nn::Bytes> raw;     ///< raw_data.
  std::optional<nn::Bytes> floats;  ///< float_data, packed; several pieces are refused.
  std::vector<uint64_t> integers;   ///< int32_data.
  bool external = false;
};

/// An attribute of a node: an integer, a list of them, a float, a text or a tensor.
struct OnnxAttribute {
  int64_t integer = 0;
  float number = 0;
  std::string text;
  std::vector<int64_t> integers;
};

struct OnnxNode {
  nn::Bytes message;  ///< For messages.
  std::string op;     ///< With its domain before it where that is not ONNX's own.
  std::string name;
  std::vector<std::string> inputs;
  std::vector<std::string> outputs;
  std::map<std::string, OnnxAttribute> attributes;

  int64_t Integer(const std::string& name, int64_t otherwise) const;
};

/// What a graph says of its weights: initialisers and the tensors of Constant nodes by name, and
/// the other nodes in their order, in which every node follows those it takes inputs from.
struct OnnxModel {
  std::map<std::string, OnnxTensor> tensors;
  std::vector<OnnxNode> nodes;
};

/// True for what may be an ONNX model: a message that begins with ir_version.
bool LooksLikeOnnx(const nn::Bytes& file);

/// Reads ModelProto (onnx.proto) as far as weights need it. Throws Error with the offset for broken
/// messages, tensors that come twice, and a file without a graph.
OnnxModel ReadOnnxModel(const nn::Bytes& file);

/// The values of a tensor as floats: float, double, half, bfloat16, and the integers that
/// quantisation uses. Throws Error for other types, for weights kept in another file, for sizes
/// that do not fit, NaN and infinity.
nn::Tensor<float> OnnxValues(const OnnxTensor& tensor);

}  // namespace gluevo::weights_tools
