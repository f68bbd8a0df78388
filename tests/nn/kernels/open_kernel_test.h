#pragma once

#include <vector>

#include "kernels/open_kernels.h"
#include "kernels/vectorized.h"

namespace gluevo::nn::kernels {

inline std::vector<const OpenKernels*> AllOpenSets() {
  std::vector<const OpenKernels*> sets = {&ScalarOpenKernels()};
  for (const Kernels* const kernels : VectorizedKernels()) {
    sets.push_back(&OpenKernelsFor(kernels->isa));
  }
  return sets;
}

}  // namespace gluevo::nn::kernels
