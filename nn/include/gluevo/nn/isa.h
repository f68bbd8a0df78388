#pragma once

#include <string>
#include <vector>

namespace gluevo::nn {

/// The instruction sets that the kernels are compiled for, slowest first.
enum class Isa {
  kReference,  ///< Plain loops that sum in double: the specification that the others are tested by.
  kPortable,   ///< Vectors of what every 64-bit CPU has (SSE4 on x86, NEON on Arm).
  kAvx2,       ///< AVX2 with FMA.
  kAvx512,     ///< AVX-512 F, BW, CD, DQ, VL.
  kAvx512Bf16,  ///< The same with AVX512_BF16: products of bf16 pairs in one instruction.
};

/// "reference", "portable", "avx2", "avx512", "avx512_bf16".
std::string IsaName(Isa isa);

/// What this CPU (and this build) can run, slowest first.
std::vector<Isa> SupportedIsas();

/// The fastest of SupportedIsas(), or what the environment variable GLUEVO_ISA names. Throws Error
/// where that is unknown or not supported here.
Isa ChooseIsa();

}  // namespace gluevo::nn
