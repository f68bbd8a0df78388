#pragma once

#include "gluevo/nn/tensor.h"
#include "onnx_model.h"

// What a graph may not have, as the names and the order of its layers would then make another
// network of it. All throw Error with the offset.

namespace gluevo::weights_tools {

/// A convolution must keep the size of its input and mix all channels.
void CheckConvolution(const OnnxNode& node, const nn::Tensor<float>& weight);

/// An operator must not be one that has weights but is not read.
void CheckKnownWeights(const OnnxNode& node);

/// Of a node that adds or multiplies constants that are neither a bias nor a batch norm.
[[noreturn]] void RefuseConstantsBehindLayer(const OnnxNode& node);

}  // namespace gluevo::weights_tools
