// Sinkhorn's iterations: the kernel's exponentials, and one pass over its rows.

#if defined(GLUEVO_NN_KERNELS_SINKHORN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_SINKHORN_INL_H_
#undef GLUEVO_NN_KERNELS_SINKHORN_INL_H_
#else
#define GLUEVO_NN_KERNELS_SINKHORN_INL_H_
#endif

#include <algorithm>
#include <limits>

#include "kernels/exp-inl.h"
#include "kernels/tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

void FastSinkhornExponentials(const SinkhornExponentials& p) {
  const Tag d;
  const Vector least = hn::Set(d, -80.0F);
  for (int64_t row = p.row_begin; row < p.row_end; ++row) {
    const float* const z = p.z + row * p.stride;
    float* const k = p.k + row * p.stride;
    const Vector u = hn::Set(d, p.u[row]);
    for (int64_t j = 0; j < p.columns; j += kLanes) {
      const Vector x = hn::Add(hn::Add(hn::Load(d, z + j), u), hn::Load(d, p.v + j));
      hn::Store(hn::IfThenElseZero(hn::Ge(x, least), Exp(x)), d, k + j);
    }
    std::fill(k + p.columns, k + p.stride, 0.0F);
  }
}

// Rows [row, row + kRows): sums, then their share of the columns, while they are close.
template <int kRows>
HWY_INLINE void ScaleRows(const SinkhornRows& p, int64_t row) {
  const Tag d;
  const float* const k = p.k + row * p.stride;
  Vector sums[kRows];
  HWY_UNROLL(4)
  for (int r = 0; r < kRows; ++r) {
    sums[r] = hn::Zero(d);
  }
  for (int64_t j = 0; j < p.stride; j += kLanes) {
    const Vector b = hn::Load(d, p.b + j);
    HWY_UNROLL(4)
    for (int r = 0; r < kRows; ++r) {
      sums[r] = hn::MulAdd(hn::Load(d, k + r * p.stride + j), b, sums[r]);
    }
  }
  Vector a[kRows];
  HWY_UNROLL(4)
  for (int r = 0; r < kRows; ++r) {
    // A row that has vanished is lifted by the largest factor there is.
    const float sum =
        std::max(hn::GetLane(hn::SumOfLanes(d, sums[r])), std::numeric_limits<float>::min());
    p.a[row + r] = p.mu[row + r] / sum;
    a[r] = hn::Set(d, p.a[row + r]);
  }
  for (int64_t j = 0; j < p.stride; j += kLanes) {
    Vector sum = hn::Load(d, p.column_sums + j);
    HWY_UNROLL(4)
    for (int r = 0; r < kRows; ++r) {
      sum = hn::MulAdd(hn::Load(d, k + r * p.stride + j), a[r], sum);
    }
    hn::Store(sum, d, p.column_sums + j);
  }
}

void FastSinkhornRows(const SinkhornRows& p) {
  int64_t row = p.row_begin;
  for (; row + 4 <= p.row_end; row += 4) {
    ScaleRows<4>(p, row);
  }
  for (; row < p.row_end; ++row) {
    ScaleRows<1>(p, row);
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
