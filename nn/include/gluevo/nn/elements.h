#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>

#include "gluevo/nn/bytes.h"
#include "gluevo/nn/tensor.h"

namespace gluevo::nn {

enum class ElementType { kF16, kBF16, kF32, kF64 };

/// Size of one element in bytes.
std::size_t ElementSize(ElementType type);

/// IEEE 754 binary16, exactly.
inline float HalfToFloat(uint16_t half) {
  const uint32_t sign = static_cast<uint32_t>(half & 0x8000U) << 16;
  const uint32_t exponent = (half >> 10) & 0x1fU;
  const uint32_t mantissa = half & 0x3ffU;
  if (exponent == 0) {  // Zero, or subnormal: mantissa * 2^-24, which float holds exactly.
    const float magnitude = static_cast<float>(mantissa) * 0x1p-24F;
    return std::bit_cast<float>(sign | std::bit_cast<uint32_t>(magnitude));
  }
  // From exponent bias 15 to 127; infinity and NaN keep all ones.
  const uint32_t widened = exponent == 0x1f ? 0xffU : exponent + (127 - 15);
  return std::bit_cast<float>(sign | (widened << 23) | (mantissa << 13));
}

/// bfloat16 is the upper half of a float.
inline float Bfloat16ToFloat(uint16_t bits) {
  return std::bit_cast<float>(static_cast<uint32_t>(bits) << 16);
}

/// The elements of `bytes`, which must be shape.size() of the given type, in their order. Throws
/// Error with the offset of the first value that is NaN or infinite or, among F64, too large for a
/// float.
Tensor<float> ReadElements(const Bytes& bytes, ElementType type, const Shape& shape,
                           const std::string& name);

/// Steps along each axis from one element to the next, in elements.
using Strides = std::array<int64_t, Shape::kMaxRank>;

/// Strides of elements that lie in their order.
Strides RowMajorStrides(const Shape& shape);

/// The elements of a tensor that lie `strides` apart in `storage`, the first one `offset` elements
/// from its start. Throws Error for negative strides, elements outside the storage, and values as
/// ReadElements does.
Tensor<float> ReadStrided(const Bytes& storage, ElementType type, const Shape& shape,
                          const Strides& strides, uint64_t offset, const std::string& name);

/// Integer tensors that published checkpoints carry and no network reads: the counters
/// "....num_batches_tracked" of batch norms in training. Readers check and then skip them.
bool IsTrainingCounter(const std::string& name);

}  // namespace gluevo::nn
