#pragma once

#include "bytes.h"
#include "gluevo/nn/weights.h"

namespace gluevo::nn {

/// Fills tensors from an .npz file: a zip archive, stored or deflated, of arrays in numpy's .npy
/// format 1.0 to 3.0 (numpy.lib.format), of '<f4', '<f2' or '<f8' (narrowed to float), in C or in
/// Fortran order.
void ParseNpz(const Bytes& file, Weights& weights);

}  // namespace gluevo::nn
