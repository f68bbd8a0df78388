#pragma once

#include <vector>

#include "kernels/kernels.h"

namespace gluevo::nn::kernels {

/// The kernels written over Highway's vectors, one table for each instruction set that this CPU
/// supports, slowest first.
std::vector<const Kernels*> VectorizedKernels();

/// The same source with vectors of one float where the build has it: what the portable set falls
/// back to, and another width for the tests.
const Kernels& ScalarKernels();

}  // namespace gluevo::nn::kernels
