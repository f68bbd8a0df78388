#pragma once

#include <cstdint>

#include "kernels/kernels.h"

namespace gluevo::nn::kernels {

/// 1/sqrt(2), the smaller of the two finite points beside 0; the other is twice as large.
inline constexpr float kWinogradPoint = 0.70710678118654752F;

/// Tiles of 4x4 outputs that are computed together: enough rows for the register tile to be busy
/// while all 36 values of their inputs stay in the second-level cache.
inline constexpr int64_t kWinogradRows = 2;
inline constexpr int64_t kWinogradColumns = 14;
inline constexpr int64_t kWinogradTiles = kWinogradRows * kWinogradColumns;

/// Floats of scratch that one call needs, for any instruction set.
int64_t WinogradScratchFloats(int64_t in_channels);

/// Floats that PackWinograd3x3 writes.
int64_t PackedWinograd3x3Floats(int64_t out_channels, int64_t in_channels);
/// Weights [out][in][3][3], transformed in double to G g G^T, as [out block][36][in][out of the
/// block], with zeros for padding channels.
void PackWinograd3x3(const float* weights, int64_t out_channels, int64_t in_channels,
                     float* packed);

}  // namespace gluevo::nn::kernels
