// The exponential of softmax and Sinkhorn.

#if defined(GLUEVO_NN_KERNELS_EXP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_EXP_INL_H_
#undef GLUEVO_NN_KERNELS_EXP_INL_H_
#else
#define GLUEVO_NN_KERNELS_EXP_INL_H_
#endif

#include "kernels/tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

// exp(x) with a relative error below kExpError for |x| <= 87; x below is taken as -87. Reduced to
// |r| <= log(2) / 2, then a polynomial of degree 5 whose coefficients minimise the largest relative
// error (1.05e-7). x above 88 overflows to nonsense.
HWY_INLINE Vector Exp(Vector x) {
  const Tag d;
  const hn::RebindToSigned<Tag> di;
  x = hn::Max(x, hn::Set(d, -87.0F));
  // Rounds to a whole number n, which the lowest bits of the sum hold.
  const Vector magic = hn::Set(d, 0x1.8p23F);
  const Vector shifted = hn::MulAdd(x, hn::Set(d, 1.44269504F), magic);
  const Vector n = hn::Sub(shifted, magic);
  // log(2) in two parts, the first with enough trailing zeros for an exact product.
  Vector r = hn::NegMulAdd(n, hn::Set(d, 0.693359375F), x);
  r = hn::NegMulAdd(n, hn::Set(d, -2.12194440e-4F), r);
  Vector p = hn::MulAdd(hn::Set(d, 0.008312521F), r, hn::Set(d, 0.041890156F));
  p = hn::MulAdd(p, r, hn::Set(d, 0.16667114F));
  p = hn::MulAdd(p, r, hn::Set(d, 0.4999923F));
  p = hn::MulAdd(p, r, hn::Set(d, 1.0F));
  p = hn::MulAdd(p, r, hn::Set(d, 1.0F));
  // Times 2^n.
  return hn::BitCast(d, hn::Add(hn::BitCast(di, p), hn::ShiftLeft<23>(hn::BitCast(di, shifted))));
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
