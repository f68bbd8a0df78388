#pragma once

#include <optional>
#include <string>

#include "gluevo/nn/bytes.h"
#include "gluevo/nn/tensor.h"

namespace gluevo::nn {

/// True for the first bytes of numpy's .npy format.
bool LooksLikeNpy(const Bytes& file);

/// The array of a .npy file, format 1.0 to 3.0 (numpy.lib.format), in C or in Fortran order, of
/// '<f4', '<f2', '<f8' (narrowed to float) or '<V2', which is how ml_dtypes' bfloat16 is saved.
/// Nothing for a batch norm's integer counter (see IsTrainingCounter). Throws Error with the offset
/// for anything else, `name` naming the array.
std::optional<Tensor<float>> ParseNpy(const Bytes& file, const std::string& name);

}  // namespace gluevo::nn
