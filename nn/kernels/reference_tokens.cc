#include <algorithm>
#include <cmath>

#include "kernels/open_kernels.h"

namespace gluevo::nn::kernels {

void ReferenceRotate(const Rotation& p) {
  for (int64_t row = 0; row < p.count; ++row) {
    for (int64_t j = 0; j < p.half_blocks * kBlock; ++j) {
      const int64_t at = row * kBlock + j % kBlock;
      const double cosine = p.cosines[j / kBlock * p.angle_block_stride + at];
      const double sine = p.sines[j / kBlock * p.angle_block_stride + at];
      float& first = p.rows[j / kBlock * p.block_stride + at];
      float& second = p.rows[(p.half_blocks + j / kBlock) * p.block_stride + at];
      const double a = first;
      const double b = second;
      first = static_cast<float>(a * cosine - b * sine);
      second = static_cast<float>(b * cosine + a * sine);
    }
  }
}

void ReferenceNormGelu(const NormGelu& p) {
  const auto count = static_cast<double>(p.channels);
  for (int64_t i = 0; i < p.count; ++i) {
    const auto at = [&](int64_t channel) -> float& {
      return p.rows[channel / kBlock * p.block_stride + i * kBlock + channel % kBlock];
    };
    double sum = 0.0;
    for (int64_t channel = 0; channel < p.channels; ++channel) {
      sum += at(channel);
    }
    const double mean = sum / count;
    double squares = 0.0;
    for (int64_t channel = 0; channel < p.channels; ++channel) {
      squares += (at(channel) - mean) * (at(channel) - mean);
    }
    const double scale = 1.0 / std::sqrt(squares / count + p.epsilon);
    for (int64_t channel = 0; channel < BlocksOf(p.channels) * kBlock; ++channel) {
      const double z = (at(channel) - mean) * scale * p.gain[channel] + p.shift[channel];
      at(channel) = static_cast<float>(0.5 * z * (1.0 + std::erf(z * std::sqrt(0.5))));
    }
  }
}

namespace {

// Of `count` scores that lie `step` apart.
float LogSum(const float* scores, int64_t count, int64_t step) {
  double largest = scores[0];
  for (int64_t i = 1; i < count; ++i) {
    largest = std::max<double>(largest, scores[i * step]);
  }
  double sum = 0.0;
  for (int64_t i = 0; i < count; ++i) {
    sum += std::exp(scores[i * step] - largest);
  }
  return static_cast<float>(largest + std::log(sum));
}

}  // namespace

void ReferenceRowLogSums(const RowLogSums& p) {
  for (int64_t row = p.row_begin; row < p.row_end; ++row) {
    p.out[row] = LogSum(p.scores + row * p.stride, p.columns, 1);
  }
}

void ReferenceColumnLogSums(const ColumnLogSums& p) {
  for (int64_t column = p.column_begin; column < p.column_end; ++column) {
    p.out[column] = LogSum(p.scores + column, p.rows, p.stride);
  }
}

}  // namespace gluevo::nn::kernels
