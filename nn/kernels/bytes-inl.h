// Products of rows of bytes.

#if defined(GLUEVO_NN_KERNELS_BYTES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_BYTES_INL_H_
#undef GLUEVO_NN_KERNELS_BYTES_INL_H_
#else
#define GLUEVO_NN_KERNELS_BYTES_INL_H_
#endif

#include <hwy/highway.h>

#include "kernels/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void FastByteProducts(const ByteProducts& p) {
  const hn::ScalableTag<int16_t> d16;
  const hn::Rebind<int8_t, decltype(d16)> d8;
  const hn::RepartitionToWide<decltype(d16)> d32;
  constexpr auto kStep = static_cast<int64_t>(hn::MaxLanes(d16));
  static_assert(kByteBlock % (2 * kStep) == 0);
  for (int64_t i = 0; i < p.rows; ++i) {
    const int8_t* const b = p.b + i * p.size;
    // Each of the two products has sums of its own, so that none waits for the one before.
    auto low = hn::Zero(d32);
    auto high = hn::Zero(d32);
    auto next_low = hn::Zero(d32);
    auto next_high = hn::Zero(d32);
    for (int64_t j = 0; j < p.size; j += 2 * kStep) {
      low = hn::ReorderWidenMulAccumulate(d32, hn::PromoteTo(d16, hn::LoadU(d8, p.a + j)),
                                          hn::PromoteTo(d16, hn::LoadU(d8, b + j)), low, high);
      next_low = hn::ReorderWidenMulAccumulate(
          d32, hn::PromoteTo(d16, hn::LoadU(d8, p.a + j + kStep)),
          hn::PromoteTo(d16, hn::LoadU(d8, b + j + kStep)), next_low, next_high);
    }
    const auto sum = hn::Add(hn::Add(low, high), hn::Add(next_low, next_high));
    p.out[i] = hn::GetLane(hn::SumOfLanes(d32, sum));
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
