// Rotary encoding, layer normalisation with GELU, and log-sum-exp along rows and columns.

#if defined(GLUEVO_NN_KERNELS_TOKENS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_TOKENS_INL_H_
#undef GLUEVO_NN_KERNELS_TOKENS_INL_H_
#else
#define GLUEVO_NN_KERNELS_TOKENS_INL_H_
#endif

#include <algorithm>
#include <cmath>

#include "kernels/exp-inl.h"
#include "kernels/tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

// erf(x) by a fraction x p(x^2) / q(x^2) whose largest error is least on |x| < 3.92, where erf
// rounds to 1.
HWY_INLINE Vector Erf(Vector x) {
  const Tag d;
  x = hn::Clamp(x, hn::Set(d, -3.92F), hn::Set(d, 3.92F));
  const Vector t = hn::Mul(x, x);
  Vector p = hn::MulAdd(hn::Set(d, 2.0347557e-06F), t, hn::Set(d, 2.8747867e-04F));
  p = hn::MulAdd(p, t, hn::Set(d, 3.8682630e-03F));
  p = hn::MulAdd(p, t, hn::Set(d, 5.3060278e-02F));
  p = hn::MulAdd(p, t, hn::Set(d, 1.9276245e-01F));
  p = hn::MulAdd(p, t, hn::Set(d, 1.1283790e+00F));
  Vector q = hn::MulAdd(hn::Set(d, 3.8070819e-05F), t, hn::Set(d, 1.1881010e-03F));
  q = hn::MulAdd(q, t, hn::Set(d, 1.5172164e-02F));
  q = hn::MulAdd(q, t, hn::Set(d, 1.1508396e-01F));
  q = hn::MulAdd(q, t, hn::Set(d, 5.0416317e-01F));
  q = hn::MulAdd(q, t, hn::Set(d, 1.0F));
  return hn::Div(hn::Mul(x, p), q);
}

HWY_INLINE Vector Gelu(Vector z) {
  const Tag d;
  const Vector half = hn::Mul(z, hn::Set(d, 0.5F));
  return hn::MulAdd(half, Erf(hn::Mul(z, hn::Set(d, 0.70710678F))), half);
}

void FastRotate(const Rotation& p) {
  const Tag d;
  for (int64_t block = 0; block < p.half_blocks; ++block) {
    float* HWY_RESTRICT first = p.rows + block * p.block_stride;
    float* HWY_RESTRICT second = first + p.half_blocks * p.block_stride;
    const float* const cosines = p.cosines + block * p.angle_block_stride;
    const float* const sines = p.sines + block * p.angle_block_stride;
    for (int64_t i = 0; i < p.count * kBlock; i += kLanes) {
      const Vector cosine = hn::Load(d, cosines + i);
      const Vector sine = hn::Load(d, sines + i);
      const Vector a = hn::Load(d, first + i);
      const Vector b = hn::Load(d, second + i);
      hn::Store(hn::NegMulAdd(b, sine, hn::Mul(a, cosine)), d, first + i);
      hn::Store(hn::MulAdd(a, sine, hn::Mul(b, cosine)), d, second + i);
    }
  }
}

// Calls f(offset, lanes that count) for the vectors of a row.
template <typename F>
HWY_INLINE void ForChannels(const NormGelu& p, const F& f) {
  for (int64_t channel = 0; channel < p.channels; channel += kLanes) {
    f(channel / kBlock * p.block_stride + channel % kBlock,
      std::min<int64_t>(kLanes, p.channels - channel));
  }
}

void FastNormGelu(const NormGelu& p) {
  const Tag d;
  const float inverse_count = 1.0F / static_cast<float>(p.channels);
  for (int64_t i = 0; i < p.count; ++i) {
    float* const row = p.rows + i * kBlock;
    Vector sums = hn::Zero(d);
    ForChannels(p, [&](int64_t at, int64_t count) HWY_ATTR {
      const Vector x = hn::Load(d, row + at);
      sums = hn::Add(sums, count == kLanes ? x : hn::IfThenElseZero(hn::FirstN(d, count), x));
    });
    const Vector mean = hn::Mul(hn::SumOfLanes(d, sums), hn::Set(d, inverse_count));
    Vector squares = hn::Zero(d);
    ForChannels(p, [&](int64_t at, int64_t count) HWY_ATTR {
      Vector x = hn::Sub(hn::Load(d, row + at), mean);
      x = count == kLanes ? x : hn::IfThenElseZero(hn::FirstN(d, count), x);
      squares = hn::MulAdd(x, x, squares);
    });
    const float variance = hn::GetLane(hn::SumOfLanes(d, squares)) * inverse_count;
    const Vector scale = hn::Set(d, 1.0F / std::sqrt(variance + p.epsilon));
    for (int64_t channel = 0; channel < BlocksOf(p.channels) * kBlock; channel += kLanes) {
      float* const at = row + channel / kBlock * p.block_stride + channel % kBlock;
      const Vector x = hn::Mul(hn::Sub(hn::Load(d, at), mean), scale);
      hn::Store(Gelu(hn::MulAdd(x, hn::Load(d, p.gain + channel), hn::Load(d, p.shift + channel))),
                d, at);
    }
  }
}

void FastRowLogSums(const RowLogSums& p) {
  const Tag d;
  const int64_t whole = p.columns / kLanes * kLanes;
  const auto rest = static_cast<std::size_t>(p.columns - whole);
  const Vector least = hn::Set(d, hwy::LowestValue<float>());
  for (int64_t row = p.row_begin; row < p.row_end; ++row) {
    const float* const scores = p.scores + row * p.stride;
    Vector largest = least;
    for (int64_t j = 0; j < whole; j += kLanes) {
      largest = hn::Max(largest, hn::Load(d, scores + j));
    }
    Vector last = least;
    if (rest > 0) {
      last = hn::IfThenElse(hn::FirstN(d, rest), hn::Load(d, scores + whole), least);
      largest = hn::Max(largest, last);
    }
    largest = hn::MaxOfLanes(d, largest);
    Vector sum = hn::Zero(d);
    for (int64_t j = 0; j < whole; j += kLanes) {
      sum = hn::Add(sum, Exp(hn::Sub(hn::Load(d, scores + j), largest)));
    }
    if (rest > 0) {
      sum = hn::Add(sum, hn::IfThenElseZero(hn::FirstN(d, rest), Exp(hn::Sub(last, largest))));
    }
    p.out[row] = hn::GetLane(largest) + std::log(hn::GetLane(hn::SumOfLanes(d, sum)));
  }
}

void FastColumnLogSums(const ColumnLogSums& p) {
  const Tag d;
  for (int64_t column = p.column_begin; column < p.column_end; column += kLanes) {
    const float* const scores = p.scores + column;
    Vector largest = hn::Load(d, scores);
    for (int64_t row = 1; row < p.rows; ++row) {
      largest = hn::Max(largest, hn::Load(d, scores + row * p.stride));
    }
    Vector sum = hn::Zero(d);
    for (int64_t row = 0; row < p.rows; ++row) {
      sum = hn::Add(sum, Exp(hn::Sub(hn::Load(d, scores + row * p.stride), largest)));
    }
    alignas(64) float sums[kLanes];
    hn::Store(sum, d, sums);
    hn::Store(largest, d, p.out + column);
    for (int i = 0; i < kLanes; ++i) {
      p.out[column + i] += std::log(sums[i]);
    }
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
