#include "kernels/winograd.h"

#include <Eigen/Core>
#include <cmath>

namespace gluevo::nn::kernels {

int64_t WinogradScratchFloats(int64_t in_channels) {
  // The widest tile of channels is 32; each of the 36 strides may grow by two cache lines.
  constexpr int64_t kWidestTile = 32;
  constexpr int64_t kPadding = 32;
  const int64_t patch = (4 * kWinogradRows + 2) * (4 * kWinogradColumns + 2) * kBlock;
  return 36 * (kWinogradTiles * (BlocksOf(in_channels) * kBlock + kWidestTile) + 2 * kPadding) +
         patch;
}

int64_t PackedWinograd3x3Floats(int64_t out_channels, int64_t in_channels) {
  return BlocksOf(out_channels) * kBlock * BlocksOf(in_channels) * kBlock * 36;
}

void PackWinograd3x3(const float* weights, int64_t out_channels, int64_t in_channels,
                     float* packed) {
  // Row of point p: (1, p, p^2) over the product of its distances to the other finite points.
  const double a = std::sqrt(0.5);
  const double b = std::sqrt(2.0);
  Eigen::Matrix<double, 6, 3> g;
  g << 1.0, 0.0, 0.0, 1.0, a, 0.5, 1.0, -a, 0.5, 1.0, b, 2.0, 1.0, -b, 2.0, 0.0, 0.0, 1.0;
  g.middleRows<2>(1) /= -1.5;
  g.middleRows<2>(3) /= 6.0;

  const int64_t in_padded = BlocksOf(in_channels) * kBlock;
  std::fill_n(packed, PackedWinograd3x3Floats(out_channels, in_channels), 0.0F);
  for (int64_t out = 0; out < out_channels; ++out) {
    for (int64_t in = 0; in < in_channels; ++in) {
      using Kernel = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
      const Eigen::Map<const Kernel> kernel(weights + (out * in_channels + in) * 9);
      const Eigen::Matrix<double, 6, 6> transformed = g * kernel.cast<double>() * g.transpose();
      for (int64_t value = 0; value < 36; ++value) {
        packed[((out / kBlock * 36 + value) * in_padded + in) * kBlock + out % kBlock] =
            static_cast<float>(transformed(value / 6, value % 6));
      }
    }
  }
}

}  // namespace gluevo::nn::kernels
