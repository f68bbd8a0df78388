#pragma once

#include <cstdint>

// What LightGlue's layers need beside products and attention. Rows are in blocks of channels,
// [block][row][kBlock], as those of the products.
namespace gluevo::nn::kernels {

/// Rotary position encoding (Su et al. 2021) of one head, in place: the plane of channels (j, half
/// + j) of every row turns by the row's angle j. (The published pairs are neighbours; a permutation
/// of channels that queries and keys share is not seen in their products.)
struct Rotation {
  float* rows = nullptr;  ///< First block of the head.
  int64_t block_stride = 0;
  int64_t half_blocks = 0;  ///< Blocks of half a head, [half_blocks][row][kBlock] of angles.
  const float* cosines = nullptr;
  const float* sines = nullptr;
  int64_t angle_block_stride = 0;
  int64_t count = 0;  ///< Rows.
};

/// Layer normalisation (Ba et al. 2016) and GELU (Hendrycks and Gimpel 2016), in place:
/// z = (x - mean) / sqrt(variance + epsilon) * gain + shift, x = z / 2 (1 + erf(z / sqrt(2))), mean
/// and (biased) variance over the channels of a row. Padding channels become 0.
struct NormGelu {
  float* rows = nullptr;
  int64_t block_stride = 0;
  int64_t channels = 0;
  const float* gain = nullptr;  ///< Both whole blocks, zeros in the padding.
  const float* shift = nullptr;
  float epsilon = 1e-5F;
  int64_t count = 0;  ///< Rows.
};

/// Logarithms of the sums of exponentials along rows [row_begin, row_end) or, by the other kernel,
/// along columns [column_begin, column_end) of scores.
struct RowLogSums {
  const float* scores = nullptr;  ///< [rows][stride], stride a multiple of kBlock.
  int64_t stride = 0;
  int64_t columns = 0;  ///< At least 1; the rest of a row is ignored.
  int64_t row_begin = 0;
  int64_t row_end = 0;
  float* out = nullptr;  ///< [rows]
};
struct ColumnLogSums {
  const float* scores = nullptr;
  int64_t stride = 0;
  int64_t rows = 0;          ///< At least 1.
  int64_t column_begin = 0;  ///< Both multiples of kBlock, so the padding must hold numbers.
  int64_t column_end = 0;
  float* out = nullptr;  ///< [stride]
};

/// Bound of the error of the fast kernels' erf: 0.3 units of 2^-24 of its fraction, the rest of
/// rounding two polynomials, a quotient and a product.
inline constexpr double kErfError = 8 * 0x1p-24;

}  // namespace gluevo::nn::kernels
