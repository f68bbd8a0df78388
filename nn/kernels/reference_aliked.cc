#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/open_kernels.h"

namespace gluevo::nn::kernels {
namespace {

double SeluOf(double x) { return kSeluScale * (x > 0.0 ? x : kSeluAlpha * std::expm1(x)); }

void ReferenceSelu(const Selu& p) {
  for (int64_t i = 0; i < p.count; ++i) {
    const double x = p.values[i] + (p.addend != nullptr ? static_cast<double>(p.addend[i]) : 0.0);
    p.values[i] = static_cast<float>(SeluOf(x));
  }
}

void ReferenceAveragePool(const AveragePool& p) {
  for (int64_t block = 0; block < p.out.blocks; ++block) {
    for (int64_t y = p.row_begin; y < p.row_end; ++y) {
      for (int64_t x = p.column_begin; x < p.column_end; ++x) {
        for (int c = 0; c < kBlock; ++c) {
          double sum = 0.0;
          for (int64_t i = 0; i < p.size * p.size; ++i) {
            sum += p.in.pixel(block, y * p.size + i / p.size, x * p.size + i % p.size)[c];
          }
          p.out.pixel(block, y, x)[c] =
              static_cast<float>(sum / static_cast<double>(p.size * p.size));
        }
      }
    }
  }
}

// The map between four pixels, zeros around it.
double Sample(const BlockedMap& map, int64_t block, int c, double y, double x) {
  const auto at = [&](double v, double u) -> double {
    const bool inside = v >= 0.0 && v < static_cast<double>(map.height) && u >= 0.0 &&
                        u < static_cast<double>(map.width);
    return inside ? map.pixel(block, static_cast<int64_t>(v), static_cast<int64_t>(u))[c] : 0.0;
  };
  const double top = std::floor(y);
  const double left = std::floor(x);
  const double below = y - top;
  const double right = x - left;
  return (1.0 - below) * ((1.0 - right) * at(top, left) + right * at(top, left + 1.0)) +
         below * ((1.0 - right) * at(top + 1.0, left) + right * at(top + 1.0, left + 1.0));
}

void ReferenceDeformableRows(const DeformableRows& p) {
  for (int64_t i = 0; i < p.count; ++i) {
    const int64_t x = p.x_begin + i;
    for (int64_t tap = 0; tap < 9; ++tap) {
      const auto offset = [&](int64_t channel) -> double {
        return std::clamp(p.offsets.pixel(channel / kBlock, p.y, x)[channel % kBlock], -p.limit,
                          p.limit);
      };
      const double v = static_cast<double>(p.y - 1 + tap / 3) + offset(2 * tap);
      const double u = static_cast<double>(x - 1 + tap % 3) + offset(2 * tap + 1);
      for (int64_t block = 0; block < p.in.blocks; ++block) {
        for (int c = 0; c < kBlock; ++c) {
          p.rows[(tap * p.in.blocks + block) * p.block_stride + i * kBlock + c] =
              static_cast<float>(Sample(p.in, block, c, v, u));
        }
      }
    }
  }
}

double Interpolate(const BlockedMap& map, int64_t block, int c, const AlignedTap& y,
                   const AlignedTap& x) {
  const auto along = [&](int64_t row) {
    return (1.0 - x.weight) * map.pixel(block, row, x.low)[c] +
           static_cast<double>(x.weight) * map.pixel(block, row, x.high)[c];
  };
  return (1.0 - y.weight) * along(y.low) + y.weight * along(y.high);
}

void ReferenceFeatureRows(const FeatureRows& p) {
  std::vector<double> values(static_cast<std::size_t>(4 * p.group_blocks * kBlock));
  for (int64_t i = 0; i < p.count; ++i) {
    double squares = 0.0;
    for (int64_t channel = 0; channel < 4 * p.group_blocks * kBlock; ++channel) {
      const int64_t block = channel / kBlock % p.group_blocks;
      const int64_t group = channel / kBlock / p.group_blocks;
      const auto c = static_cast<int>(channel % kBlock);
      const double value =
          group == 0 ? SeluOf(p.rows[block * p.block_stride + i * kBlock + c])
                     : Interpolate(p.maps[group - 1], block, c, p.taps_y[group - 1][p.pixels_y[i]],
                                   p.taps_x[group - 1][p.pixels_x[i]]);
      values[static_cast<std::size_t>(channel)] = value;
      squares += value * value;
    }
    const double length = std::max(std::sqrt(squares), 1e-12);
    for (int64_t channel = 0; channel < 4 * p.group_blocks * kBlock; ++channel) {
      p.rows[channel / kBlock * p.block_stride + i * kBlock + channel % kBlock] =
          static_cast<float>(values[static_cast<std::size_t>(channel)] / length);
    }
  }
}

void ReferenceScoreRow(const ScoreRow& p) {
  for (int64_t x = 0; x < p.width; ++x) {
    for (int64_t c = 0; c < p.channels; ++c) {
      double sum = p.row[x * ScoreStride(p.channels) + c];
      for (int map = 0; map < 3; ++map) {
        sum += Interpolate(p.maps[map], 0, static_cast<int>(c), p.tap_y[map], p.taps_x[map][x]);
      }
      p.out[c * p.plane_stride + x] = static_cast<float>(SeluOf(sum));
    }
  }
}

void ReferencePlanarConv3x3(const PlanarConv3x3& p) {
  for (int64_t o = 0; o < p.out_channels; ++o) {
    for (int64_t y = p.row_begin; y < p.row_end; ++y) {
      for (int64_t x = 0; x < p.width; ++x) {
        double sum = 0.0;
        for (int64_t c = 0; c < p.in_channels; ++c) {
          for (int64_t tap = 0; tap < 9; ++tap) {
            sum += static_cast<double>(p.weights[(o * p.in_channels + c) * 9 + tap]) *
                   p.in[c * p.plane_stride + (y + tap / 3) * p.row_stride + kPlaneMargin + x - 1 +
                        tap % 3];
          }
        }
        p.out[o * p.plane_stride + (y + 1) * p.row_stride + kPlaneMargin + x] = static_cast<float>(
            p.activation == Activation::kSelu ? SeluOf(sum) : 1.0 / (1.0 + std::exp(-sum)));
      }
    }
  }
}

}  // namespace

const OpenKernels& ReferenceOpenKernels() {
  static constexpr OpenKernels kKernels = {
      .isa = Isa::kReference,
      .rotate = ReferenceRotate,
      .norm_gelu = ReferenceNormGelu,
      .row_log_sums = ReferenceRowLogSums,
      .column_log_sums = ReferenceColumnLogSums,
      .selu = ReferenceSelu,
      .average_pool = ReferenceAveragePool,
      .deformable_rows = ReferenceDeformableRows,
      .feature_rows = ReferenceFeatureRows,
      .score_row = ReferenceScoreRow,
      .planar_conv3x3 = ReferencePlanarConv3x3,
  };
  return kKernels;
}

}  // namespace gluevo::nn::kernels
