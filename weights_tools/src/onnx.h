#pragma once

#include "containers.h"
#include "gluevo/nn/bytes.h"

namespace gluevo::weights_tools {

/// Fills a container from an ONNX model of a SuperPoint or a SuperGlue: the weights of Conv, Gemm
/// and MatMul, dequantised where they are int8 with scales, and batch norms, under the names that
/// the initialisers have, or else by their order in the graph. Throws Error with the offset.
void ParseOnnx(const nn::Bytes& file, Container& container);

}  // namespace gluevo::weights_tools
