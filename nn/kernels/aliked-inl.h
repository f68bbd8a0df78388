// ALIKED's kernels.

#if defined(GLUEVO_NN_KERNELS_ALIKED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_ALIKED_INL_H_
#undef GLUEVO_NN_KERNELS_ALIKED_INL_H_
#else
#define GLUEVO_NN_KERNELS_ALIKED_INL_H_
#endif

#include <algorithm>
#include <cmath>

#include <hwy/cache_control.h>

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

// The four pixels of a map around a position.
struct Around {
  const float* top_left;
  const float* top_right;
  const float* bottom_left;
  const float* bottom_right;
  Vector right;
  Vector below;

  HWY_INLINE Around(const BlockedMap& map, const AlignedTap& y, const AlignedTap& x)
      : top_left(map.pixel(0, y.low, x.low)),
        top_right(map.pixel(0, y.low, x.high)),
        bottom_left(map.pixel(0, y.high, x.low)),
        bottom_right(map.pixel(0, y.high, x.high)),
        right(hn::Set(Tag(), x.weight)),
        below(hn::Set(Tag(), y.weight)) {}

  // Channels `at` floats on.
  HWY_INLINE Vector Interpolate(int64_t at) const {
    const Tag d;
    const Vector a = hn::Load(d, top_left + at);
    const Vector b = hn::Load(d, bottom_left + at);
    const Vector upper = hn::MulAdd(right, hn::Sub(hn::Load(d, top_right + at), a), a);
    const Vector lower = hn::MulAdd(right, hn::Sub(hn::Load(d, bottom_right + at), b), b);
    return hn::MulAdd(below, hn::Sub(lower, upper), upper);
  }
};

// What row i reads of the finest map, which no cache holds.
HWY_INLINE void FetchFeatures(const FeatureRows& p, int64_t i) {
  const BlockedMap& map = p.maps[0];
  const AlignedTap& y = p.taps_y[0][p.pixels_y[i]];
  const AlignedTap& x = p.taps_x[0][p.pixels_x[i]];
  const float* low = map.pixel(0, y.low, x.low);
  const float* high = map.pixel(0, y.high, x.low);
  const int64_t right = static_cast<int64_t>(x.high - x.low) * kBlock;
  for (int64_t block = 0; block < p.group_blocks; ++block) {
    hwy::Prefetch(low);
    hwy::Prefetch(low + right);
    hwy::Prefetch(high);
    hwy::Prefetch(high + right);
    low += map.block_stride();
    high += map.block_stride();
  }
}

void FastFeatureRows(const FeatureRows& p) {
  const Tag d;
  constexpr int64_t kAhead = 6;  // Rows, whose reads are under way together.
  for (int64_t i = 0; i < std::min(kAhead, p.count); ++i) {
    FetchFeatures(p, i);
  }
  for (int64_t i = 0; i < p.count; ++i) {
    if (i + kAhead < p.count) {
      FetchFeatures(p, i + kAhead);
    }
    float* to = p.rows + i * kBlock;
    Vector squares = hn::Zero(d);
    for (int64_t block = 0; block < p.group_blocks; ++block, to += p.block_stride) {
      for (int lane = 0; lane < kBlock; lane += kLanes) {
        const Vector value = SeluOf(hn::Load(d, to + lane));
        hn::Store(value, d, to + lane);
        squares = hn::MulAdd(value, value, squares);
      }
    }
    for (int map = 0; map < 3; ++map) {
      const Around around(p.maps[map], p.taps_y[map][p.pixels_y[i]], p.taps_x[map][p.pixels_x[i]]);
      const int64_t map_stride = p.maps[map].block_stride();
      for (int64_t block = 0; block < p.group_blocks; ++block, to += p.block_stride) {
        for (int lane = 0; lane < kBlock; lane += kLanes) {
          const Vector value = around.Interpolate(block * map_stride + lane);
          hn::Store(value, d, to + lane);
          squares = hn::MulAdd(value, value, squares);
        }
      }
    }
    const float length = std::sqrt(hn::GetLane(hn::SumOfLanes(d, squares)));
    const Vector scale = hn::Set(d, 1.0F / std::max(length, 1e-12F));
    to = p.rows + i * kBlock;
    for (int64_t block = 0; block < 4 * p.group_blocks; ++block, to += p.block_stride) {
      for (int lane = 0; lane < kBlock; lane += kLanes) {
        hn::Store(hn::Mul(hn::Load(d, to + lane), scale), d, to + lane);
      }
    }
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
