#pragma once

namespace gluevo::nn {

/// Of the operands of matrix products; their sums are always in float.
enum class Precision {
  kFloat,
  /// bfloat16: 8 bits of mantissa instead of 24, about twice as fast where the CPU has AVX512_BF16
  /// (Isa::kAvx512Bf16), slow elsewhere.
  kBf16,
};

}  // namespace gluevo::nn
