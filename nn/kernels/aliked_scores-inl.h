// ALIKED's score head.

#if defined(GLUEVO_NN_KERNELS_ALIKED_SCORES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_ALIKED_SCORES_INL_H_
#undef GLUEVO_NN_KERNELS_ALIKED_SCORES_INL_H_
#else
#define GLUEVO_NN_KERNELS_ALIKED_SCORES_INL_H_
#endif

#include <algorithm>

#include "kernels/aliked-inl.h"
#include "kernels/aliked_kernels.h"
#include "kernels/exp-inl.h"
#include "kernels/tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

HWY_INLINE Vector SigmoidOf(Vector x) {
  const Tag d;
  const Vector one = hn::Set(d, 1.0F);
  return hn::Div(one, hn::Add(one, Exp(hn::Min(hn::Neg(x), hn::Set(d, 87.0F)))));
}

using GroupTag = hn::CappedTag<float, kScoreGroup>;
inline constexpr int kGroupLanes = static_cast<int>(hn::MaxLanes(GroupTag()));

// low + weight (high - low), channel by channel.
HWY_INLINE hn::Vec<GroupTag> Between(const float* low, const float* high, float weight) {
  const GroupTag d;
  const auto from = hn::Load(d, low);
  return hn::MulAdd(hn::Set(d, weight), hn::Sub(hn::Load(d, high), from), from);
}

// Channels [first, first + kScoreGroup) of a row of a map between its two rows at `tap`:
// [width][kScoreGroup].
HWY_INLINE void BlendRows(const BlockedMap& map, const AlignedTap& tap, int64_t first, float* to) {
  const float* const low = map.pixel(0, tap.low, 0) + first;
  const float* const high = map.pixel(0, tap.high, 0) + first;
  for (int64_t x = 0; x < map.width; ++x) {
    for (int lane = 0; lane < kScoreGroup; lane += kGroupLanes) {
      const int64_t at = x * kBlock + lane;
      hn::Store(Between(low + at, high + at, tap.weight), GroupTag(), to + x * kScoreGroup + lane);
    }
  }
}

// [kBlock pixels][kScoreGroup] to [kScoreGroup][kBlock pixels].
HWY_INLINE void GroupToPlanes(const float* HWY_RESTRICT pixels, float* HWY_RESTRICT planes) {
#if HWY_TARGET == HWY_SCALAR
  for (int i = 0; i < kBlock * kScoreGroup; ++i) {
    planes[i % kScoreGroup * kBlock + i / kScoreGroup] = pixels[i];
  }
#else
  const Tag d;
  for (int x = 0; x < kBlock; x += kLanes) {
    // Channels c and c + 4 of a pixel after each other.
    const float* const from = pixels + x * kScoreGroup;
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
  const int64_t row_stride = ScoreStride(p.channels);
  for (int64_t first = 0; first < p.channels; first += kScoreGroup) {
    const float* rows[3];
    float* scratch = p.scratch;
    for (int map = 0; map < 3; ++map) {
      BlendRows(p.maps[map], p.tap_y[map], first, scratch);
      rows[map] = scratch;
      scratch += p.maps[map].width * kScoreGroup;
    }
    const int64_t channels = std::min<int64_t>(kScoreGroup, p.channels - first);
    alignas(64) float pixels[kBlock * kScoreGroup] = {};
    alignas(64) float planes[kScoreGroup * kBlock];
    for (int64_t begin = 0; begin < p.width; begin += kBlock) {
      const int64_t count = std::min<int64_t>(kBlock, p.width - begin);
      for (int64_t i = 0; i < count; ++i) {
        const int64_t x = begin + i;
        for (int lane = 0; lane < kScoreGroup; lane += kGroupLanes) {
          auto sum = hn::Load(GroupTag(), p.row + x * row_stride + first + lane);
          for (int map = 0; map < 3; ++map) {
            const AlignedTap& tap = p.taps_x[map][x];
            const float* const row = rows[map] + lane;
            sum = hn::Add(sum, Between(row + tap.low * kScoreGroup, row + tap.high * kScoreGroup,
                                       tap.weight));
          }
          hn::Store(sum, GroupTag(), pixels + i * kScoreGroup + lane);
        }
      }
      GroupToPlanes(pixels, planes);
      for (int64_t c = 0; c < channels; ++c) {
        float* const plane = planes + c * kBlock;
        float* const out = p.out + (first + c) * p.plane_stride + begin;
        float* const whole = count == kBlock ? out : plane;
        for (int lane = 0; lane < kBlock; lane += kLanes) {
          hn::StoreU(SeluOf(hn::Load(d, plane + lane)), d, whole + lane);
        }
        if (count < kBlock) {
          std::copy_n(plane, count, out);
        }
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
