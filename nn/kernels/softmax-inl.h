// SuperPoint's detector softmax.

#if defined(GLUEVO_NN_KERNELS_SOFTMAX_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_SOFTMAX_INL_H_
#undef GLUEVO_NN_KERNELS_SOFTMAX_INL_H_
#else
#define GLUEVO_NN_KERNELS_SOFTMAX_INL_H_
#endif

#include "kernels/exp-inl.h"
#include "kernels/tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

void FastDetectorSoftmax(const DetectorSoftmax& p) {
  const Tag d;
  const int64_t score_stride = p.cell_columns * 8;
  for (int64_t cell_y = p.cell_row_begin; cell_y < p.cell_row_end; ++cell_y) {
    for (int64_t cell_x = 0; cell_x < p.cell_columns; ++cell_x) {
      const float* const logits = p.logits + (cell_y * p.cell_columns + cell_x) * p.stride;
      const Vector dustbin = hn::Set(d, logits[64]);
      Vector largest = dustbin;
      for (int i = 0; i < 64; i += kLanes) {
        largest = hn::Max(largest, hn::LoadU(d, logits + i));
      }
      largest = hn::MaxOfLanes(d, largest);
      alignas(64) float values[64];
      Vector sum = hn::Zero(d);
      for (int i = 0; i < 64; i += kLanes) {
        const Vector e = Exp(hn::Sub(hn::LoadU(d, logits + i), largest));
        hn::Store(e, d, values + i);
        sum = hn::Add(sum, e);
      }
      const Vector total = hn::Add(hn::SumOfLanes(d, sum), Exp(hn::Sub(dustbin, largest)));
      const Vector inverse = hn::Div(hn::Set(d, 1.0F), total);
      for (int i = 0; i < 64; i += kLanes) {
        hn::Store(hn::Mul(hn::Load(d, values + i), inverse), d, values + i);
      }
      float* const cell = p.scores + cell_y * 8 * score_stride + cell_x * 8;
      for (int y = 0; y < 8; ++y) {
        hwy::CopyBytes<8 * sizeof(float)>(values + 8 * y, cell + y * score_stride);
      }
    }
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
