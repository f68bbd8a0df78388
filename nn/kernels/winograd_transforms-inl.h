// The transforms of Winograd's minimal filtering F(4x4, 3x3), of which winograd-inl.h makes
// convolutions. The points are 0, +-1/sqrt(2), +-sqrt(2) and infinity, whose rounding errors are
// half those of the usual integer points (Barabasz et al. 2020).

#if defined(GLUEVO_NN_KERNELS_WINOGRAD_TRANSFORMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_WINOGRAD_TRANSFORMS_INL_H_
#undef GLUEVO_NN_KERNELS_WINOGRAD_TRANSFORMS_INL_H_
#else
#define GLUEVO_NN_KERNELS_WINOGRAD_TRANSFORMS_INL_H_
#endif

#include <algorithm>

#include "kernels/tile-inl.h"
#include "kernels/winograd.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

// B^T d, rows in order of the points 0, a, -a, b, -b, infinity with a = 1/sqrt(2), b = sqrt(2).
HWY_INLINE void TransformInput(Vector d0, Vector d1, Vector d2, Vector d3, Vector d4, Vector d5,
                               Vector* HWY_RESTRICT out) {
  const Tag d;
  const Vector two = hn::Set(d, 2.0F);
  const Vector half = hn::Set(d, 0.5F);
  const Vector a = hn::Set(d, kWinogradPoint);
  const Vector b = hn::Set(d, 2.0F * kWinogradPoint);
  const Vector five_halves = hn::Set(d, 2.5F);
  const Vector even_a = hn::NegMulAdd(two, d2, d4);
  const Vector odd_a = hn::NegMulAdd(two, d1, d3);
  const Vector even_b = hn::NegMulAdd(half, d2, d4);
  const Vector odd_b = hn::NegMulAdd(half, d1, d3);
  out[0] = hn::NegMulAdd(five_halves, d2, hn::Add(d0, d4));
  out[1] = hn::MulAdd(a, odd_a, even_a);
  out[2] = hn::NegMulAdd(a, odd_a, even_a);
  out[3] = hn::MulAdd(b, odd_b, even_b);
  out[4] = hn::NegMulAdd(b, odd_b, even_b);
  out[5] = hn::NegMulAdd(five_halves, d3, hn::Add(d1, d5));
}

// A^T m: output i is the sum over points p of p^i m_p, and for the last one m_infinity.
HWY_INLINE void TransformOutput(Vector m0, Vector m1, Vector m2, Vector m3, Vector m4, Vector m5,
                                Vector* HWY_RESTRICT out) {
  const Tag d;
  const Vector two = hn::Set(d, 2.0F);
  const Vector half = hn::Set(d, 0.5F);
  const Vector a = hn::Set(d, kWinogradPoint);
  const Vector sum_a = hn::Add(m1, m2);
  const Vector sum_b = hn::Add(m3, m4);
  const Vector odd_a = hn::Sub(m1, m2);
  const Vector odd_b = hn::Sub(m3, m4);
  // b = 2 a, a^3 = a / 2, b^3 = 4 a.
  out[0] = hn::Add(m0, hn::Add(sum_a, sum_b));
  out[1] = hn::Mul(a, hn::MulAdd(two, odd_b, odd_a));
  out[2] = hn::MulAdd(two, sum_b, hn::Mul(half, sum_a));
  out[3] = hn::MulAdd(a, hn::MulAdd(hn::Set(d, 4.0F), odd_b, hn::Mul(half, odd_a)), m5);
}

// A row of tiles and one vector of channels: from pixels at `in` (of the patch's top-left corner,
// one pixel above and left of the outputs) to their 36 values at v.
HWY_NOINLINE void TransformTileRow(const float* HWY_RESTRICT in, int64_t row_stride, int64_t tiles,
                                   float* HWY_RESTRICT v, int64_t v_stride) {
  const Tag d;
  // Few enough that what passes between the two passes stays close.
  constexpr int64_t kTilesAtOnce = 7;
  constexpr int64_t kColumns = 4 * kTilesAtOnce + 2;
  alignas(64) float vertical[6][kColumns * kLanes];
  for (int64_t first = 0; first < tiles; first += kTilesAtOnce) {
    const int64_t count = std::min(kTilesAtOnce, tiles - first);
    for (int64_t x = 0; x < 4 * count + 2; ++x) {
      const float* const column = in + (4 * first + x) * kBlock;
      Vector out[6];
      TransformInput(hn::Load(d, column), hn::Load(d, column + row_stride),
                     hn::Load(d, column + 2 * row_stride), hn::Load(d, column + 3 * row_stride),
                     hn::Load(d, column + 4 * row_stride), hn::Load(d, column + 5 * row_stride),
                     out);
      HWY_UNROLL(6)
      for (int i = 0; i < 6; ++i) {
        hn::Store(out[i], d, vertical[i] + x * kLanes);
      }
    }
    for (int64_t i = 0; i < 6; ++i) {
      for (int64_t t = 0; t < count; ++t) {
        const float* const row = vertical[i] + 4 * t * kLanes;
        Vector out[6];
        TransformInput(hn::Load(d, row), hn::Load(d, row + kLanes), hn::Load(d, row + 2 * kLanes),
                       hn::Load(d, row + 3 * kLanes), hn::Load(d, row + 4 * kLanes),
                       hn::Load(d, row + 5 * kLanes), out);
        float* const to = v + 6 * i * v_stride + (first + t) * kBlock;
        HWY_UNROLL(6)
        for (int j = 0; j < 6; ++j) {
          hn::Store(out[j], d, to + j * v_stride);
        }
      }
    }
  }
}

// The 4x4 outputs of one tile and vector of channels, activation included.
HWY_INLINE void TransformTileBack(const Conv3x3& p, const float* HWY_RESTRICT m, int64_t m_stride,
                                  int64_t channel, Vector (&out)[4][4]) {
  const Tag d;
  alignas(64) float vertical[4][6 * kLanes];
  for (int64_t j = 0; j < 6; ++j) {
    const float* const column = m + j * m_stride;
    const int64_t stride = 6 * m_stride;
    Vector values[4];
    TransformOutput(hn::Load(d, column), hn::Load(d, column + stride),
                    hn::Load(d, column + 2 * stride), hn::Load(d, column + 3 * stride),
                    hn::Load(d, column + 4 * stride), hn::Load(d, column + 5 * stride), values);
    HWY_UNROLL(4)
    for (int i = 0; i < 4; ++i) {
      hn::Store(values[i], d, vertical[i] + j * kLanes);
    }
  }
  const Vector bias = hn::Load(d, p.bias + channel);
  const Vector least = hn::Set(d, p.relu ? 0.0F : hwy::LowestValue<float>());
  HWY_UNROLL(4)
  for (int i = 0; i < 4; ++i) {
    const float* const row = vertical[i];
    TransformOutput(hn::Load(d, row), hn::Load(d, row + kLanes), hn::Load(d, row + 2 * kLanes),
                    hn::Load(d, row + 3 * kLanes), hn::Load(d, row + 4 * kLanes),
                    hn::Load(d, row + 5 * kLanes), out[i]);
    HWY_UNROLL(4)
    for (int j = 0; j < 4; ++j) {
      out[i][j] = hn::Max(hn::Add(out[i][j], bias), least);
    }
  }
  if (p.scale != nullptr) {
    const Vector scale = hn::Load(d, p.scale + channel);
    const Vector shift = hn::Load(d, p.shift + channel);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        out[i][j] = hn::MulAdd(out[i][j], scale, shift);
      }
    }
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
