// SuperPoint's detector softmax and the row pass of Sinkhorn.

#if defined(GLUEVO_NN_KERNELS_SOFTMAX_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_SOFTMAX_INL_H_
#undef GLUEVO_NN_KERNELS_SOFTMAX_INL_H_
#else
#define GLUEVO_NN_KERNELS_SOFTMAX_INL_H_
#endif

#include <algorithm>
#include <cmath>

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

// exponentials[j] = exp(z[j] + v[j] + shift); returns their sum. Padding columns get 0.
HWY_INLINE float SinkhornExponentials(const SinkhornRows& p, const float* HWY_RESTRICT z,
                                      float shift, float* HWY_RESTRICT exponentials) {
  const Tag d;
  const Vector shifts = hn::Set(d, shift);
  Vector sum = hn::Zero(d);
  int64_t j = 0;
  for (; j + kLanes <= p.columns; j += kLanes) {
    const Vector e = Exp(hn::Add(hn::Add(hn::Load(d, z + j), shifts), hn::Load(d, p.v + j)));
    hn::Store(e, d, exponentials + j);
    sum = hn::Add(sum, e);
  }
  if (j < p.columns) {
    const auto inside = hn::FirstN(d, static_cast<std::size_t>(p.columns - j));
    const Vector e = hn::IfThenElseZero(
        inside, Exp(hn::Add(hn::Add(hn::Load(d, z + j), shifts), hn::Load(d, p.v + j))));
    hn::Store(e, d, exponentials + j);
    sum = hn::Add(sum, e);
  }
  return hn::GetLane(hn::SumOfLanes(d, sum));
}

void FastSinkhornRows(const SinkhornRows& p) {
  const Tag d;
  const int64_t padded = (p.columns + kLanes - 1) / kLanes * kLanes;
  const int64_t scratch_stride = BlocksOf(p.columns) * kBlock;
  for (int64_t first = p.row_begin; first < p.row_end; first += kSinkhornRows) {
    const int64_t rows = std::min(kSinkhornRows, p.row_end - first);
    float weights[kSinkhornRows] = {};
    for (int64_t i = 0; i < rows; ++i) {
      const int64_t row = first + i;
      const float* const z = p.z + row * p.stride;
      float* const exponentials = p.scratch + i * scratch_stride;
      // With u of the iteration before, rows sum to about 1 unless v has changed much. A sum within
      // these bounds has entries near it, of which none was cut off by Exp.
      constexpr float kLeast = 1e-6F;
      constexpr float kMost = 1e6F;
      float shift = p.u[row] - p.log_mu[row];
      float sum = SinkhornExponentials(p, z, shift, exponentials);
      if (!(sum > kLeast && sum < kMost)) {
        float largest = hwy::LowestValue<float>();
        for (int64_t j = 0; j < p.columns; ++j) {
          largest = std::max(largest, z[j] + p.v[j]);
        }
        shift = -largest;
        sum = SinkhornExponentials(p, z, shift, exponentials);
      }
      p.u[row] = p.log_mu[row] + shift - std::log(sum);
      weights[i] = std::exp(p.log_mu[row]) / sum;
    }
    if (rows == kSinkhornRows) {
      static_assert(kSinkhornRows == 4);
      const Vector w0 = hn::Set(d, weights[0]);
      const Vector w1 = hn::Set(d, weights[1]);
      const Vector w2 = hn::Set(d, weights[2]);
      const Vector w3 = hn::Set(d, weights[3]);
      const float* const e = p.scratch;
      for (int64_t j = 0; j < padded; j += kLanes) {
        Vector sum = hn::Load(d, p.column_sums + j);
        sum = hn::MulAdd(hn::Load(d, e + j), w0, sum);
        sum = hn::MulAdd(hn::Load(d, e + scratch_stride + j), w1, sum);
        sum = hn::MulAdd(hn::Load(d, e + 2 * scratch_stride + j), w2, sum);
        sum = hn::MulAdd(hn::Load(d, e + 3 * scratch_stride + j), w3, sum);
        hn::Store(sum, d, p.column_sums + j);
      }
    } else {
      for (int64_t i = 0; i < rows; ++i) {
        const Vector w = hn::Set(d, weights[i]);
        for (int64_t j = 0; j < padded; j += kLanes) {
          hn::Store(hn::MulAdd(hn::Load(d, p.scratch + i * scratch_stride + j), w,
                               hn::Load(d, p.column_sums + j)),
                    d, p.column_sums + j);
        }
      }
    }
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
