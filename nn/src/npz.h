#pragma once

#include "gluevo/nn/bytes.h"
#include "gluevo/nn/weights.h"

namespace gluevo::nn {

/// Fills tensors from an .npz file: a zip archive, stored or deflated, of arrays as ParseNpy reads
/// them.
void ParseNpz(const Bytes& file, Weights& weights);

}  // namespace gluevo::nn
