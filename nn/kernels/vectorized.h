#pragma once

#include <vector>

#include "kernels/kernels.h"

namespace gluevo::nn::kernels {

/// The kernels written over Highway's vectors, one table for each instruction set that this CPU
/// supports, slowest first.
std::vector<const Kernels*> VectorizedKernels();

/// The AVX-512 set with AVX512_BF16; null where this CPU has not got it.
const Kernels* Avx512Bf16Kernels();

/// The same source with vectors of one float where the build has it: what the portable set falls
/// back to, and another width for the tests.
const Kernels& ScalarKernels();

}  // namespace gluevo::nn::kernels
