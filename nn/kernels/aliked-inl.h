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

// Channels of the score head's first layer that are computed together: all that the published
// networks have.
inline constexpr int kGroup = 8;
using GroupTag = hn::CappedTag<float, kGroup>;
inline constexpr int kGroupLanes = static_cast<int>(hn::MaxLanes(GroupTag()));

// low + weight (high - low), channel by channel.
HWY_INLINE hn::Vec<GroupTag> Between(const float* low, const float* high, float weight) {
  const GroupTag d;
  const auto from = hn::Load(d, low);
  return hn::MulAdd(hn::Set(d, weight), hn::Sub(hn::Load(d, high), from), from);
}

// Channels [first, first + kGroup) of a row of a map between its two rows at `tap`:
// [width][kGroup].
HWY_INLINE void BlendRows(const BlockedMap& map, const AlignedTap& tap, int64_t first, float* to) {
  const float* const low = map.pixel(0, tap.low, 0) + first;
  const float* const high = map.pixel(0, tap.high, 0) + first;
  for (int64_t x = 0; x < map.width; ++x) {
    for (int lane = 0; lane < kGroup; lane += kGroupLanes) {
      const int64_t at = x * kBlock + lane;
      hn::Store(Between(low + at, high + at, tap.weight), GroupTag(), to + x * kGroup + lane);
    }
  }
}

// [kBlock pixels][kGroup] to [kGroup][kBlock pixels].
HWY_INLINE void GroupToPlanes(const float* HWY_RESTRICT pixels, float* HWY_RESTRICT planes) {
#if HWY_TARGET == HWY_SCALAR
  for (int i = 0; i < kBlock * kGroup; ++i) {
    planes[i % kGroup * kBlock + i / kGroup] = pixels[i];
  }
#else
  const Tag d;
  for (int x = 0; x < kBlock; x += kLanes) {
    // Channels c and c + 4 of a pixel after each other.
    const float* const from = pixels + x * kGroup;
    Vector a[4];
    Vector b[4];
    hn::LoadInterleaved4(d, from, a[0], a[1], a[2], a[3]);
    hn::LoadInterleaved4(d, from + 4 * kLanes, b[0], b[1], b[2], b[3]);
    HWY_UNROLL(4)
    for (int c = 0; c < 4; ++c) {
      hn::Store(hn::ConcatEven(d, b[c], a[c]), d, planes + c * kBlock + x);
      hn::Store(hn::ConcatOdd(d, b[c], a[c]), d, planes + (c + 4) * kBlock + x);
    }
  }
#endif
}

// The maps are interpolated along y first, where each has the fewer pixels.
void FastScoreRow(const ScoreRow& p) {
  const Tag d;
  for (int64_t first = 0; first < p.channels; first += kGroup) {
    const float* rows[3];
    float* scratch = p.scratch;
    for (int map = 0; map < 3; ++map) {
      BlendRows(p.maps[map], p.tap_y[map], first, scratch);
      rows[map] = scratch;
      scratch += p.maps[map].width * kGroup;
    }
    const int64_t channels = std::min<int64_t>(kGroup, p.channels - first);
    alignas(64) float pixels[kBlock * kGroup] = {};
    alignas(64) float planes[kGroup * kBlock];
    for (int64_t begin = 0; begin < p.width; begin += kBlock) {
      const int64_t count = std::min<int64_t>(kBlock, p.width - begin);
      for (int64_t i = 0; i < count; ++i) {
        const int64_t x = begin + i;
        for (int lane = 0; lane < kGroup; lane += kGroupLanes) {
          auto sum = hn::Load(GroupTag(), p.row + x * kBlock + first + lane);
          for (int map = 0; map < 3; ++map) {
            const AlignedTap& tap = p.taps_x[map][x];
            const float* const row = rows[map] + lane;
            sum =
                hn::Add(sum, Between(row + tap.low * kGroup, row + tap.high * kGroup, tap.weight));
          }
          hn::Store(sum, GroupTag(), pixels + i * kGroup + lane);
        }
      }
      GroupToPlanes(pixels, planes);
      for (int64_t c = 0; c < channels; ++c) {
        float* const plane = planes + c * kBlock;
        for (int lane = 0; lane < kBlock; lane += kLanes) {
          hn::Store(SeluOf(hn::Load(d, plane + lane)), d, plane + lane);
        }
        std::copy_n(plane, count, p.out + (first + c) * p.plane_stride + begin);
      }
    }
  }
}

// kOut channels of kVectors vectors of pixels: as many sums as multiply-adds are under way at a
// time, which each weight and each input serves several of.
template <int kOut, int kVectors>
HWY_INLINE void PlanarPixels(const PlanarConv3x3& p, int64_t y, int64_t x, int64_t out_channel) {
  const Tag d;
  Vector sums[kOut][kVectors];
  HWY_UNROLL(4)
  for (int o = 0; o < kOut; ++o) {
    HWY_UNROLL(8)
    for (int v = 0; v < kVectors; ++v) {
      sums[o][v] = hn::Zero(d);
    }
  }
  for (int64_t c = 0; c < p.in_channels; ++c) {
    const float* const plane = p.in + c * p.plane_stride + y * p.row_stride + kPlaneMargin + x - 1;
    const float* const weights = p.weights + (out_channel * p.in_channels + c) * 9;
    for (int64_t tap = 0; tap < 9; ++tap) {
      const float* const at = plane + tap / 3 * p.row_stride + tap % 3;
      Vector weight[kOut];
      HWY_UNROLL(4)
      for (int o = 0; o < kOut; ++o) {
        weight[o] = hn::Set(d, weights[o * p.in_channels * 9 + tap]);
      }
      HWY_UNROLL(8)
      for (int v = 0; v < kVectors; ++v) {
        const Vector in = hn::LoadU(d, at + v * kLanes);
        HWY_UNROLL(4)
        for (int o = 0; o < kOut; ++o) {
          sums[o][v] = hn::MulAdd(in, weight[o], sums[o][v]);
        }
      }
    }
  }
  HWY_UNROLL(4)
  for (int o = 0; o < kOut; ++o) {
    float* const out =
        p.out + (out_channel + o) * p.plane_stride + (y + 1) * p.row_stride + kPlaneMargin + x;
    HWY_UNROLL(8)
    for (int v = 0; v < kVectors; ++v) {
      const Vector value =
          p.activation == Activation::kSelu ? SeluOf(sums[o][v]) : SigmoidOf(sums[o][v]);
      hn::Store(value, d, out + v * kLanes);
    }
  }
}

template <int kOut>
HWY_NOINLINE void PlanarRow(const PlanarConv3x3& p, int64_t y, int64_t out_channel) {
  constexpr int kSums = kTileRows * kTileVectors;
  constexpr int kMost = kOut > 1 ? (kSums >= 16 ? 4 : 2) : 8;
  constexpr int kLeast = kLanes < kBlock ? 2 : 1;  // kBlock pixels are whole numbers of these.
  int64_t x = 0;
  for (; x + kMost * kLanes <= p.width; x += kMost * kLanes) {
    PlanarPixels<kOut, kMost>(p, y, x, out_channel);
  }
  for (; x < p.width; x += kLeast * kLanes) {
    PlanarPixels<kOut, kLeast>(p, y, x, out_channel);
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
