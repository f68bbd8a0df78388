// The fast kernels, compiled once for each instruction set by Highway's foreach_target.

#include "kernels/vectorized.h"

#include <algorithm>
#include <chrono>
#include <limits>

#define GLUEVO_SET_NAMESPACE HWY_NAMESPACE
#define GLUEVO_SET_HAS_BF16 0

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/vectorized.cc"
#include <hwy/foreach_target.h>
// Per-target headers come after foreach_target, which includes this file once more a target.
#include "kernels/table-inl.h"

#if HWY_ONCE
namespace gluevo::nn::kernels {

std::vector<const Kernels*> VectorizedKernels() {
#if HWY_ARCH_X86
  int64_t supported = hwy::SupportedTargets();
  // Highway 1.0.3 takes it for granted that a system saves wide registers where it cannot be asked
  // which ones; the compiler's check does not.
  if (!__builtin_cpu_supports("avx2")) {
    supported &= ~HWY_AVX2;
  }
  if (!__builtin_cpu_supports("avx512f")) {
    supported &= ~HWY_AVX3;
  }
  std::vector<const Kernels*> tables;
  const auto add_if_supported = [&](int64_t target, const Kernels& table) {
    if ((supported & target) != 0) {
      tables.push_back(&table);
    }
  };
  // On the few x86 CPUs without SSE4 the portable kernels are scalar ones.
  if ((supported & HWY_SSE4) == 0) {
    tables.push_back(&ScalarKernels());
  }
  add_if_supported(HWY_SSE4, N_SSE4::Table());
  add_if_supported(HWY_AVX2, N_AVX2::Table());
  add_if_supported(HWY_AVX3, N_AVX3::Table());
  if (const Kernels* const table = Avx512Bf16Kernels(); table != nullptr) {
    tables.push_back(table);
  }
  return tables;
#else
  // Not asked of Highway, which counts NEON as there only with the cryptographic instructions, that
  // no kernel uses and some boards have not got.
  return {&HWY_STATIC_DISPATCH(Table)()};
#endif
}

const Kernels& ScalarKernels() {
#if HWY_TARGETS & HWY_SCALAR
  return N_SCALAR::Table();
#else
  return HWY_STATIC_DISPATCH(Table)();
#endif
}

}  // namespace gluevo::nn::kernels
#endif  // HWY_ONCE
