// SuperPoint's detector softmax and the row pass of Sinkhorn.

#if defined(GLUEVO_NN_KERNELS_SOFTMAX_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_SOFTMAX_INL_H_
#undef GLUEVO_NN_KERNELS_SOFTMAX_INL_H_
#else
#define GLUEVO_NN_KERNELS_SOFTMAX_INL_H_
#endif

#include <hwy/contrib/math/math-inl.h>

#include <algorithm>
#include <cmath>

#include "kernels/tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::HWY_NAMESPACE {

void FastDetectorSoftmax(const DetectorSoftmax& p) {
  const Tag d;
  for (int64_t cell_y = p.cell_row_begin; cell_y < p.cell_row_end; ++cell_y) {
    for (int64_t cell_x = 0; cell_x < p.cell_columns; ++cell_x) {
      const float* const logits = p.logits + (cell_y * p.cell_columns + cell_x) * p.stride;
      Vector largest = hn::Set(d, logits[64]);
      for (int i = 0; i < 64; i += kLanes) {
        largest = hn::Max(largest, hn::LoadU(d, logits + i));
      }
      largest = hn::MaxOfLanes(d, largest);
      alignas(64) float exponentials[64];
      Vector sum = hn::Zero(d);
      for (int i = 0; i < 64; i += kLanes) {
        const Vector e = hn::Exp(d, hn::Sub(hn::LoadU(d, logits + i), largest));
        hn::Store(e, d, exponentials + i);
        sum = hn::Add(sum, e);
      }
      const float dustbin = std::exp(logits[64] - hn::GetLane(largest));
      const float inverse = 1.0F / (hn::GetLane(hn::SumOfLanes(d, sum)) + dustbin);
      float* const cell = p.scores + cell_y * 8 * p.cell_columns * 8 + cell_x * 8;
      for (int64_t i = 0; i < 64; ++i) {
        cell[i / 8 * p.cell_columns * 8 + i % 8] = exponentials[i] * inverse;
      }
    }
  }
}

void FastSinkhornRows(const SinkhornRows& p) {
  const Tag d;
  const int64_t whole = p.columns / kLanes * kLanes;
  for (int64_t row = p.row_begin; row < p.row_end; ++row) {
    const float* const z = p.z + row * p.stride;
    Vector largest_lanes = hn::Set(d, hwy::LowestValue<float>());
    for (int64_t j = 0; j < whole; j += kLanes) {
      const Vector value = hn::Add(hn::Load(d, z + j), hn::Load(d, p.v + j));
      hn::Store(value, d, p.scratch + j);
      largest_lanes = hn::Max(largest_lanes, value);
    }
    float largest = hn::GetLane(hn::MaxOfLanes(d, largest_lanes));
    for (int64_t j = whole; j < p.columns; ++j) {
      p.scratch[j] = z[j] + p.v[j];
      largest = std::max(largest, p.scratch[j]);
    }
    const Vector shift = hn::Set(d, largest);
    Vector sum_lanes = hn::Zero(d);
    for (int64_t j = 0; j < whole; j += kLanes) {
      const Vector e = hn::Exp(d, hn::Sub(hn::Load(d, p.scratch + j), shift));
      hn::Store(e, d, p.scratch + j);
      sum_lanes = hn::Add(sum_lanes, e);
    }
    float sum = hn::GetLane(hn::SumOfLanes(d, sum_lanes));
    for (int64_t j = whole; j < p.columns; ++j) {
      p.scratch[j] = std::exp(p.scratch[j] - largest);
      sum += p.scratch[j];
    }
    p.u[row] = p.log_mu[row] - largest - std::log(sum);
    const float weight = std::exp(p.log_mu[row]) / sum;
    const Vector weights = hn::Set(d, weight);
    for (int64_t j = 0; j < whole; j += kLanes) {
      hn::Store(hn::MulAdd(hn::Load(d, p.scratch + j), weights, hn::Load(d, p.column_sums + j)), d,
                p.column_sums + j);
    }
    for (int64_t j = whole; j < p.columns; ++j) {
      p.column_sums[j] += p.scratch[j] * weight;
    }
  }
}

}  // namespace gluevo::nn::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
