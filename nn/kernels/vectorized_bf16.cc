// The AVX-512 kernels once more, with the products of bf16 pairs of AVX512_BF16, a set that this
// version of Highway does not know.

#include <algorithm>
#include <chrono>
#include <limits>

#include "kernels/vectorized.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/vectorized_bf16.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET == HWY_AVX3
#undef HWY_TARGET_STR
#define HWY_TARGET_STR HWY_TARGET_STR_AVX3 ",avx512bf16"
#define GLUEVO_SET_NAMESPACE N_AVX3_BF16
#define GLUEVO_SET_HAS_BF16 1
#include "kernels/table-inl.h"
#endif

#if HWY_ONCE
namespace gluevo::nn::kernels {

const Kernels* Avx512Bf16Kernels() {
#if HWY_ARCH_X86
  if ((hwy::SupportedTargets() & HWY_AVX3) != 0 && __builtin_cpu_supports("avx512bf16")) {
    return &N_AVX3_BF16::Table();
  }
#endif
  return nullptr;
}

}  // namespace gluevo::nn::kernels
#endif  // HWY_ONCE
