// ALIKED's kernels.

#if defined(GLUEVO_NN_KERNELS_ALIKED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_ALIKED_INL_H_
#undef GLUEVO_NN_KERNELS_ALIKED_INL_H_
#else
#define GLUEVO_NN_KERNELS_ALIKED_INL_H_
#endif

#include <algorithm>
#include <cmath>

#include "kernels/aliked_kernels.h"
#include "kernels/exp-inl.h"
#include "kernels/tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

HWY_INLINE Vector SeluOf(Vector x) {
  const Tag d;
  const Vector zero = hn::Zero(d);
  const Vector slope = hn::Set(d, static_cast<float>(kSeluScale * kSeluAlpha));
  const Vector below = hn::MulSub(Exp(hn::Min(x, zero)), slope, slope);
  return hn::MulAdd(hn::Max(x, zero), hn::Set(d, static_cast<float>(kSeluScale)), below);
}

HWY_INLINE Vector SigmoidOf(Vector x) {
  const Tag d;
  const Vector one = hn::Set(d, 1.0F);
  return hn::Div(one, hn::Add(one, Exp(hn::Min(hn::Neg(x), hn::Set(d, 87.0F)))));
}

void FastSelu(const Selu& p) {
  const Tag d;
  for (int64_t i = 0; i < p.count; i += kLanes) {
    Vector x = hn::Load(d, p.values + i);
    if (p.addend != nullptr) {
      x = hn::Add(x, hn::Load(d, p.addend + i));
    }
    hn::Store(SeluOf(x), d, p.values + i);
  }
}

void FastAveragePool(const AveragePool& p) {
  const Tag d;
  const Vector scale = hn::Set(d, 1.0F / static_cast<float>(p.size * p.size));
  for (int64_t block = 0; block < p.out.blocks; ++block) {
    for (int64_t y = p.row_begin; y < p.row_end; ++y) {
      for (int64_t x = p.column_begin; x < p.column_end; ++x) {
        const float* const window = p.in.pixel(block, y * p.size, x * p.size);
        float* const to = p.out.pixel(block, y, x);
        for (int lane = 0; lane < kBlock; lane += kLanes) {
          Vector sum = hn::Zero(d);
          for (int64_t v = 0; v < p.size; ++v) {
            for (int64_t u = 0; u < p.size; ++u) {
              sum = hn::Add(sum, hn::Load(d, window + v * p.in.row_stride() + u * kBlock + lane));
            }
          }
          hn::Store(hn::Mul(sum, scale), d, to + lane);
        }
      }
    }
  }
}

void FastDeformableRows(const DeformableRows& p) {
  const Tag d;
  const auto height = static_cast<float>(p.in.height);
  const auto width = static_cast<float>(p.in.width);
  for (int64_t i = 0; i < p.count; ++i) {
    const int64_t x = p.x_begin + i;
    for (int64_t tap = 0; tap < 9; ++tap) {
      const auto offset = [&](int64_t channel) {
        return std::clamp(p.offsets.pixel(channel / kBlock, p.y, x)[channel % kBlock], -p.limit,
                          p.limit);
      };
      const float v = static_cast<float>(p.y - 1 + tap / 3) + offset(2 * tap);
      const float u = static_cast<float>(x - 1 + tap % 3) + offset(2 * tap + 1);
      float* const to = p.rows + tap * p.in.blocks * p.block_stride + i * kBlock;
      if (!(v > -1.0F && v < height && u > -1.0F && u < width)) {
        for (int64_t block = 0; block < p.in.blocks; ++block) {
          std::fill_n(to + block * p.block_stride, kBlock, 0.0F);
        }
        continue;
      }
      const float top = std::floor(v);
      const float left = std::floor(u);
      const Vector below = hn::Set(d, v - top);
      const Vector right = hn::Set(d, u - left);
      const float* from = p.in.pixel(0, static_cast<int64_t>(top), static_cast<int64_t>(left));
      const int64_t row_stride = p.in.row_stride();
      for (int64_t block = 0; block < p.in.blocks; ++block, from += p.in.block_stride()) {
        for (int lane = 0; lane < kBlock; lane += kLanes) {
          const float* const at = from + lane;
          const Vector a = hn::Load(d, at);
          const Vector b = hn::Load(d, at + row_stride);
          const Vector upper = hn::MulAdd(right, hn::Sub(hn::Load(d, at + kBlock), a), a);
          const Vector lower =
              hn::MulAdd(right, hn::Sub(hn::Load(d, at + row_stride + kBlock), b), b);
          hn::Store(hn::MulAdd(below, hn::Sub(lower, upper), upper), d,
                    to + block * p.block_stride + lane);
        }
      }
    }
  }
}

// Channels [lane, lane + kLanes) of a block of a map between four pixels.
HWY_INLINE Vector Interpolate(const BlockedMap& map, int64_t block, const AlignedTap& y,
                              const AlignedTap& x, int lane) {
  const Tag d;
  const Vector right = hn::Set(d, x.weight);
  const Vector a = hn::Load(d, map.pixel(block, y.low, x.low) + lane);
  const Vector b = hn::Load(d, map.pixel(block, y.high, x.low) + lane);
  const Vector upper =
      hn::MulAdd(right, hn::Sub(hn::Load(d, map.pixel(block, y.low, x.high) + lane), a), a);
  const Vector lower =
      hn::MulAdd(right, hn::Sub(hn::Load(d, map.pixel(block, y.high, x.high) + lane), b), b);
  return hn::MulAdd(hn::Set(d, y.weight), hn::Sub(lower, upper), upper);
}

void FastFeatureRows(const FeatureRows& p) {
  const Tag d;
  for (int64_t i = 0; i < p.count; ++i) {
    float* const row = p.rows + i * kBlock;
    Vector squares = hn::Zero(d);
    const auto put = [&](int64_t block, int lane, Vector value) HWY_ATTR {
      hn::Store(value, d, row + block * p.block_stride + lane);
      squares = hn::MulAdd(value, value, squares);
    };
    for (int64_t block = 0; block < p.group_blocks; ++block) {
      for (int lane = 0; lane < kBlock; lane += kLanes) {
        put(block, lane, SeluOf(hn::Load(d, row + block * p.block_stride + lane)));
        for (int map = 0; map < 3; ++map) {
          put((map + 1) * p.group_blocks + block, lane,
              Interpolate(p.maps[map], block, p.taps_y[map][p.pixels_y[i]],
                          p.taps_x[map][p.pixels_x[i]], lane));
        }
      }
    }
    const float length = std::sqrt(hn::GetLane(hn::SumOfLanes(d, squares)));
    const Vector scale = hn::Set(d, 1.0F / std::max(length, 1e-12F));
    for (int64_t block = 0; block < 4 * p.group_blocks; ++block) {
      for (int lane = 0; lane < kBlock; lane += kLanes) {
        float* const at = row + block * p.block_stride + lane;
        hn::Store(hn::Mul(hn::Load(d, at), scale), d, at);
      }
    }
  }
}

void FastScoreRow(const ScoreRow& p) {
  const Tag d;
  for (int64_t x = 0; x < p.width; ++x) {
    alignas(64) float values[kBlock];
    for (int lane = 0; lane < p.channels; lane += kLanes) {
      Vector sum = hn::Load(d, p.row + x * kBlock + lane);
      for (int map = 0; map < 3; ++map) {
        sum = hn::Add(sum, Interpolate(p.maps[map], 0, p.tap_y[map], p.taps_x[map][x], lane));
      }
      hn::Store(SeluOf(sum), d, values + lane);
    }
    for (int64_t c = 0; c < p.channels; ++c) {
      p.out[c * p.plane_stride + x] = values[c];
    }
  }
}

// kOut channels of a row, as many vectors of pixels at a time as fill the registers.
template <int kOut>
HWY_NOINLINE void PlanarRow(const PlanarConv3x3& p, int64_t y, int64_t out_channel) {
  const Tag d;
  constexpr int kVectors = kLanes < 16 ? 2 : 1;
  static_assert(kBlock % (kVectors * kLanes) == 0);
  for (int64_t x = 0; x < p.width; x += kVectors * kLanes) {
    Vector sums[kOut][kVectors];
    HWY_UNROLL(4)
    for (int o = 0; o < kOut; ++o) {
      HWY_UNROLL(2)
      for (int v = 0; v < kVectors; ++v) {
        sums[o][v] = hn::Zero(d);
      }
    }
    for (int64_t c = 0; c < p.in_channels; ++c) {
      const float* const plane =
          p.in + c * p.plane_stride + y * p.row_stride + kPlaneMargin + x - 1;
      const float* const weights = p.weights + (out_channel * p.in_channels + c) * 9;
      for (int64_t tap = 0; tap < 9; ++tap) {
        const float* const at = plane + tap / 3 * p.row_stride + tap % 3;
        HWY_UNROLL(2)
        for (int v = 0; v < kVectors; ++v) {
          const Vector in = hn::LoadU(d, at + v * kLanes);
          HWY_UNROLL(4)
          for (int o = 0; o < kOut; ++o) {
            sums[o][v] =
                hn::MulAdd(in, hn::Set(d, weights[o * p.in_channels * 9 + tap]), sums[o][v]);
          }
        }
      }
    }
    HWY_UNROLL(4)
    for (int o = 0; o < kOut; ++o) {
      float* const out =
          p.out + (out_channel + o) * p.plane_stride + (y + 1) * p.row_stride + kPlaneMargin + x;
      HWY_UNROLL(2)
      for (int v = 0; v < kVectors; ++v) {
        const Vector value =
            p.activation == Activation::kSelu ? SeluOf(sums[o][v]) : SigmoidOf(sums[o][v]);
        hn::Store(value, d, out + v * kLanes);
      }
    }
  }
}

void FastPlanarConv3x3(const PlanarConv3x3& p) {
  for (int64_t y = p.row_begin; y < p.row_end; ++y) {
    int64_t channel = 0;
    for (; channel + 4 <= p.out_channels; channel += 4) {
      PlanarRow<4>(p, y, channel);
    }
    for (; channel < p.out_channels; ++channel) {
      PlanarRow<1>(p, y, channel);
    }
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
