#pragma once

#include <bit>
#include <cstdint>

namespace gluevo::nn::kernels {

/// To the nearest, ties to even; for finite values. Bfloat16ToFloat is the way back.
inline uint16_t ToBf16(float value) {
  const uint32_t bits = std::bit_cast<uint32_t>(value);
  return static_cast<uint16_t>((bits + 0x7FFFU + (bits >> 16 & 1U)) >> 16);
}

}  // namespace gluevo::nn::kernels
