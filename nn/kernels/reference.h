#pragma once

#include "kernels/kernels.h"

namespace gluevo::nn::kernels {

/// The specification of every kernel: plain loops, sums in double.
const Kernels& ReferenceKernels();

}  // namespace gluevo::nn::kernels
