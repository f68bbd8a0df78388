#pragma once

#include <cstdint>

#include "kernels/kernels.h"

// What ALIKED's layers need beside 3x3 convolutions and products (Zhao et al. 2023). Maps are
// BlockedMaps, whose halo of zeros is what samples outside of a map see, or planes of single
// channels.
namespace gluevo::nn::kernels {

/// x > 0 ? s x : s a (e^x - 1), Klambauer et al. 2017.
inline constexpr double kSeluScale = 1.0507009873554805;
inline constexpr double kSeluAlpha = 1.6732632423543772;

/// values = selu(values + addend), element by element.
struct Selu {
  float* values = nullptr;
  const float* addend = nullptr;  ///< Or null.
  int64_t count = 0;              ///< A multiple of kBlock.
};

/// Means of windows of size x size pixels. The sides of `out` are those of `in` over the size; what
/// to compute is in pixels of `out`.
struct AveragePool {
  BlockedMap in;
  int64_t size = 0;
  BlockedMap out;
  int64_t row_begin = 0;
  int64_t row_end = 0;
  int64_t column_begin = 0;
  int64_t column_end = 0;
};

/// What a deformable 3x3 convolution (Dai et al. 2017) multiplies, as left operand of a product:
/// pixel x of a row of `count` becomes row x of nine times the blocks of `in`, tap after tap. Tap t
/// of pixel (y, x) is the bilinear sample of `in`, with zeros around it, at
/// (y - 1 + t / 3 + dy, x - 1 + t % 3 + dx), where dy and dx are channels 2 t and 2 t + 1 of
/// `offsets`, clamped to +-limit.
struct DeformableRows {
  BlockedMap in;
  BlockedMap offsets;  ///< Of the same size.
  float limit = 0.0F;
  int64_t y = 0;
  int64_t x_begin = 0;
  int64_t count = 0;
  float* rows = nullptr;  ///< [9 * in.blocks][row][kBlock]
  int64_t block_stride = 0;
};

/// Bilinear interpolation along one axis with corners aligned: element i of n reads i (m - 1) /
/// (n - 1) of m.
struct AlignedTap {
  int32_t low = 0;  ///< Of the two that are read; both are within the map.
  int32_t high = 0;
  float weight = 0.0F;  ///< Of high.
};

/// Features of single pixels: four groups of channels, of which the first is given and activated by
/// SELU, and the others are interpolated from coarser maps; the row is divided by its length, at
/// least 1e-12.
struct FeatureRows {
  float* rows =
      nullptr;  ///< [4 * group_blocks][row][kBlock]; the first group is read, all written.
  int64_t block_stride = 0;
  int64_t group_blocks = 0;
  BlockedMap maps[3];                ///< Each of group_blocks blocks.
  const AlignedTap* taps_y[3] = {};  ///< For every pixel of the finest map.
  const AlignedTap* taps_x[3] = {};
  const int32_t* pixels_y = nullptr;  ///< Of each row.
  const int32_t* pixels_x = nullptr;
  int64_t count = 0;
};

/// Channels of the score head's first layer that are computed together: all that the published
/// networks have.
inline constexpr int kScoreGroup = 8;

/// Floats of a pixel in ScoreRow::row.
inline constexpr int64_t ScoreStride(int64_t channels) {
  return (channels + kScoreGroup - 1) / kScoreGroup * kScoreGroup;
}

/// One row of the score head's first activation: selu(row + maps interpolated at (y, x)), as
/// planes.
struct ScoreRow {
  const float* row = nullptr;  ///< [width][ScoreStride(channels)]; aligned.
  BlockedMap maps[3];          ///< Of one block.
  AlignedTap tap_y[3];
  const AlignedTap* taps_x[3] = {};
  int64_t width = 0;
  int64_t channels = 0;  ///< At most kBlock.
  float* out = nullptr;  ///< Channel c of pixel x at out[c * plane_stride + x].
  int64_t plane_stride = 0;
  /// ScoreScratchFloats floats, aligned, of this thread only.
  float* scratch = nullptr;
};

/// For coarser maps of these widths.
inline constexpr int64_t ScoreScratchFloats(int64_t width0, int64_t width1, int64_t width2) {
  return (width0 + width1 + width2) * kScoreGroup;
}

enum class Activation { kSelu, kSigmoid };

/// Floats of a plane's row before its first and after its last pixel: vectors stay aligned.
inline constexpr int64_t kPlaneMargin = kBlock;

/// out = activation(conv3x3(in)) of few channels without bias, on planes with a halo of zeros, one
/// row on top and below and kPlaneMargin floats on both sides: [channel][height + 2][row_stride],
/// pixel (y, x) at (y + 1) * row_stride + kPlaneMargin + x.
struct PlanarConv3x3 {
  const float* in = nullptr;
  int64_t in_channels = 0;
  const float* weights = nullptr;  ///< [out][in][3][3]
  Activation activation = Activation::kSelu;
  float* out = nullptr;  ///< Same layout; the halo is not written.
  int64_t out_channels = 0;
  int64_t height = 0;
  int64_t width = 0;  ///< A multiple of kBlock.
  int64_t row_stride = 0;
  int64_t plane_stride = 0;
  int64_t row_begin = 0;
  int64_t row_end = 0;
};

}  // namespace gluevo::nn::kernels
