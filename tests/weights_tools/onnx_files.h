#pragma once

#include <cstdint>
#include <string>
#include <vector>

// ONNX models put together field by field (onnx.proto).

namespace gluevo::weights_tools {

inline std::string Varint(uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7) {
    bytes += static_cast<char>(0x80 | (value & 0x7f));
  }
  return bytes + static_cast<char>(value);
}
inline std::string Number(uint64_t field, uint64_t value) {
  return Varint(field << 3) + Varint(value);
}
inline std::string Text(uint64_t field, const std::string& text) {
  return Varint(field << 3 | 2) + Varint(text.size()) + text;
}

/// A TensorProto of this type, its values in raw_data.
inline std::string Tensor(const std::string& name, const std::vector<uint64_t>& dims, uint64_t type,
                          const std::string& raw) {
  std::string tensor;
  for (const uint64_t extent : dims) {
    tensor += Number(1, extent);
  }
  return tensor + Number(2, type) + Text(8, name) + Text(9, raw);
}

inline std::string Node(const std::string& op, const std::vector<std::string>& inputs,
                        const std::string& output, const std::string& attributes = "") {
  std::string node;
  for (const std::string& input : inputs) {
    node += Text(1, input);
  }
  return node + Text(2, output) + Text(3, "the node") + Text(4, op) + attributes;
}

inline std::string Integers(const std::string& name, const std::vector<uint64_t>& values) {
  std::string attribute = Text(1, name);
  for (const uint64_t value : values) {
    attribute += Number(8, value);
  }
  return Text(5, attribute);
}

inline std::string Model(const std::vector<std::string>& nodes,
                         const std::vector<std::string>& tensors) {
  std::string graph;
  for (const std::string& node : nodes) {
    graph += Text(1, node);
  }
  for (const std::string& tensor : tensors) {
    graph += Text(5, tensor);
  }
  return Number(1, 8) + Text(7, graph);
}

}  // namespace gluevo::weights_tools
