#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "onnx_model.h"

namespace gluevo::weights_tools {

/// Where a value of the graph comes from, and what lies between.
struct OnnxOrigin {
  int linear = -1;  ///< Index of the linear map; -1 where it comes from something else.
  bool relu = false;
};

/// The origins of the values of a graph whose nodes are visited in their order.
class OnnxOrigins {
 public:
  /// Of a node's input, be it there or not.
  OnnxOrigin Of(const OnnxNode& node, std::size_t input) const;

  /// Of a node's first output, which it must have.
  void Set(const OnnxNode& node, const OnnxOrigin& origin);

  /// The node is another use of what `first` did: their first outputs have the same origin.
  void SetAsOf(const OnnxNode& first, const OnnxNode& node);

  /// Operators that change no weights hand their first input's origin on.
  void PassThrough(const OnnxNode& node);

 private:
  std::map<std::string, OnnxOrigin> origins_;
};

}  // namespace gluevo::weights_tools
