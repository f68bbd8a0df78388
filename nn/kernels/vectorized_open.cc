// The kernels of ALIKED and LightGlue, compiled once for each instruction set.

#include <algorithm>
#include <cmath>
#include <vector>

#include "gluevo/nn/error.h"
#include "kernels/open_kernels.h"

#define GLUEVO_SET_NAMESPACE HWY_NAMESPACE
#define GLUEVO_SET_HAS_BF16 0

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/vectorized_open.cc"
#include <hwy/foreach_target.h>
// Per-target headers come after foreach_target, which includes this file once more a target.
#include "kernels/open_table-inl.h"

#if HWY_ONCE
namespace gluevo::nn::kernels {

const OpenKernels& OpenKernelsFor(Isa isa) {
  KernelsFor(isa);  // Throws where this CPU has not got it.
  if (isa == Isa::kReference) {
    return ReferenceOpenKernels();
  }
#if HWY_ARCH_X86
  switch (isa) {
    case Isa::kAvx512:
    case Isa::kAvx512Bf16:
      return N_AVX3::OpenTable();
    case Isa::kAvx2:
      return N_AVX2::OpenTable();
    default:
      return (hwy::SupportedTargets() & HWY_SSE4) != 0 ? N_SSE4::OpenTable() : ScalarOpenKernels();
  }
#else
  return HWY_STATIC_DISPATCH(OpenTable)();
#endif
}

const OpenKernels& ScalarOpenKernels() {
#if HWY_TARGETS & HWY_SCALAR
  return N_SCALAR::OpenTable();
#else
  return HWY_STATIC_DISPATCH(OpenTable)();
#endif
}

}  // namespace gluevo::nn::kernels
#endif  // HWY_ONCE
