#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/open_kernels.h"
#include "nn/kernels/kernel_test.h"
#include "nn/kernels/open_kernel_test.h"

namespace gluevo::nn::kernels {
namespace {

void CheckRotation(int64_t half_blocks, int64_t count) {
  SCOPED_TRACE(testing::Message() << half_blocks << " blocks, " << count << " rows");
  const int64_t block_stride = (count + 2) * kBlock;
  const int64_t angle_block_stride = (count + 1) * kBlock;
  const Tensor<float> rows = Random(2 * half_blocks * block_stride, -3.0F, 3.0F);
  const Tensor<float> angles = Random(half_blocks * angle_block_stride, -7.0F, 7.0F);
  Tensor<float> cosines(angles.shape());
  Tensor<float> sines(angles.shape());
  for (int64_t i = 0; i < angles.size(); ++i) {
    cosines[i] = std::cos(angles[i]);
    sines[i] = std::sin(angles[i]);
  }
  const auto run = [&](const OpenKernels& kernels) {
    Tensor<float> turned = rows;
    kernels.rotate({.rows = turned.data(),
                    .block_stride = block_stride,
                    .half_blocks = half_blocks,
                    .cosines = cosines.data(),
                    .sines = sines.data(),
                    .angle_block_stride = angle_block_stride,
                    .count = count});
    return turned;
  };
  const Tensor<float> expected = run(ReferenceOpenKernels());
  for (const OpenKernels* const kernels : AllOpenSets()) {
    const Tensor<float> turned = run(*kernels);
    for (int64_t i = 0; i < turned.size(); ++i) {
      // Two products and their sum; rows beyond the last one are not touched.
      const bool outside = i % block_stride >= count * kBlock;
      ASSERT_LE(std::abs(turned[i] - expected[i]), outside ? 0.0 : Gamma(3) * 2.0 * 3.0)
          << IsaName(kernels->isa) << " " << i;
      ASSERT_TRUE(!outside || expected[i] == rows[i]);
    }
  }
}

TEST(RotationTest, AgreesWithTheReference) {
  for (const int64_t half_blocks : {1, 2, 3}) {
    for (const int64_t count : {1, 5, 16, 37}) {
      CheckRotation(half_blocks, count);
    }
  }
}

// The reference itself: a quarter turn takes the first half to the second one.
TEST(RotationTest, TurnsTheFirstHalfTowardsTheSecond) {
  Tensor<float> rows(Shape{2 * kBlock});
  rows[3] = 2.0F;
  const Tensor<float> cosines(Shape{kBlock});
  const Tensor<float> sines = Filled(kBlock, 1.0F);
  ReferenceOpenKernels().rotate({.rows = rows.data(),
                                 .block_stride = kBlock,
                                 .half_blocks = 1,
                                 .cosines = cosines.data(),
                                 .sines = sines.data(),
                                 .count = 1});
  EXPECT_EQ(rows[3], 0.0F);
  EXPECT_EQ(rows[kBlock + 3], 2.0F);
}

void CheckNormGelu(int64_t channels, int64_t count, float range) {
  SCOPED_TRACE(testing::Message() << channels << " channels, " << count << " rows, " << range);
  const int64_t blocks = BlocksOf(channels);
  const int64_t block_stride = (count + 1) * kBlock;
  Tensor<float> rows = Random(blocks * block_stride, -range, range);
  Tensor<float> gain = Random(blocks * kBlock, -2.0F, 2.0F);
  Tensor<float> shift = Random(blocks * kBlock, -2.0F, 2.0F);
  std::fill(gain.data() + channels, gain.data() + gain.size(), 0.0F);
  std::fill(shift.data() + channels, shift.data() + shift.size(), 0.0F);
  const auto run = [&](const OpenKernels& kernels) {
    Tensor<float> out = rows;
    kernels.norm_gelu({.rows = out.data(),
                       .block_stride = block_stride,
                       .channels = channels,
                       .gain = gain.data(),
                       .shift = shift.data(),
                       .count = count});
    return out;
  };
  const Tensor<float> expected = run(ReferenceOpenKernels());
  for (const OpenKernels* const kernels : AllOpenSets()) {
    const Tensor<float> out = run(*kernels);
    for (int64_t row = 0; row < count; ++row) {
      double squares = 0.0;
      double sum = 0.0;
      for (int64_t c = 0; c < channels; ++c) {
        const double x = rows[c / kBlock * block_stride + row * kBlock + c % kBlock];
        sum += x;
        squares += x * x;
      }
      const auto n = static_cast<double>(channels);
      const double variance = squares / n - sum / n * sum / n;
      const double scale = 1.0 / std::sqrt(variance + 1e-5);
      // The mean errs by gamma of the absolute values, so does what it is taken off (once more),
      // and the scale by half of what the variance errs: gamma and twice the mean's error.
      const double mean_error = Gamma(channels + 2) * range;
      const double scale_error = 0.5 * (Gamma(channels + 6) + 4.0 * mean_error * scale) + Gamma(4);
      for (int64_t c = 0; c < blocks * kBlock; ++c) {
        const int64_t at = c / kBlock * block_stride + row * kBlock + c % kBlock;
        const double normal = std::abs(rows[at] - sum / n) * scale;
        const double z_error =
            std::abs(gain[c]) * (mean_error * scale + 2.0 * kUnit * range * scale +
                                 normal * (scale_error + Gamma(3))) +
            Gamma(1) * std::abs(shift[c]);
        // GELU's slope is below 1.13; erf(z / sqrt(2)) errs by kErfError and by what its argument
        // is rounded, of slope z sqrt(2 / pi) exp(-z^2 / 2) < 0.5 a unit.
        const double z = std::abs(gain[c]) * normal + std::abs(shift[c]);
        const double bound = 1.13 * z_error + 0.5 * z * (kErfError + 2.0 * kUnit) + Gamma(2) * z;
        ASSERT_LE(std::abs(out[at] - expected[at]), 2.0 * bound)
            << IsaName(kernels->isa) << " " << row << " " << c;
        ASSERT_TRUE(c < channels || out[at] == 0.0F);
      }
    }
    for (int64_t i = 0; i < out.size(); ++i) {
      ASSERT_TRUE(i % block_stride < count * kBlock || out[i] == rows[i]);
    }
  }
}

TEST(NormGeluTest, AgreesWithTheReference) {
  for (const int64_t channels : {1, 15, 16, 17, 33, 192, 512}) {
    for (const int64_t count : {1, 3, 20}) {
      CheckNormGelu(channels, count, 1.0F);
    }
    CheckNormGelu(channels, 5, 50.0F);
  }
}

// With gain 0 what is left is GELU of the shift: the error function over its whole range.
TEST(NormGeluTest, GeluIsCloseToTheExactOneEverywhere) {
  constexpr int64_t kChannels = 16384;
  Tensor<float> gain(Shape{kChannels});
  Tensor<float> shift(Shape{kChannels});
  for (int64_t i = 0; i < kChannels; ++i) {
    shift[i] = (static_cast<float>(i) - 8192.0F) / 1024.0F;
  }
  for (const OpenKernels* const kernels : AllOpenSets()) {
    Tensor<float> rows = Filled(kChannels, 1.0F);
    kernels->norm_gelu({.rows = rows.data(),
                        .block_stride = kBlock,
                        .channels = kChannels,
                        .gain = gain.data(),
                        .shift = shift.data(),
                        .count = 1});
    for (int64_t i = 0; i < kChannels; ++i) {
      const double z = shift[i];
      const double exact = 0.5 * z * (1.0 + std::erf(z * std::sqrt(0.5)));
      ASSERT_LE(std::abs(rows[i] - exact), std::abs(0.5 * z) * (kErfError + 4.0 * kUnit))
          << IsaName(kernels->isa) << " " << z;
    }
  }
}

void CheckLogSums(int64_t row_count, int64_t columns, float range) {
  SCOPED_TRACE(testing::Message() << row_count << " x " << columns << ", " << range);
  const int64_t stride = BlocksOf(columns) * kBlock;
  Tensor<float> scores = Random(row_count * stride, -range, range);
  const auto run = [&](const OpenKernels& kernels, bool rows) {
    Tensor<float> out = Filled(rows ? row_count + 1 : stride, kGuard);
    if (rows) {
      kernels.row_log_sums({.scores = scores.data(),
                            .stride = stride,
                            .columns = columns,
                            .row_begin = row_count > 2 ? 1 : 0,
                            .row_end = row_count,
                            .out = out.data()});
    } else {
      kernels.column_log_sums({.scores = scores.data(),
                               .stride = stride,
                               .rows = row_count,
                               .column_begin = stride > kBlock ? kBlock : 0,
                               .column_end = stride,
                               .out = out.data()});
    }
    return out;
  };
  for (const bool rows : {true, false}) {
    const Tensor<float> expected = run(ReferenceOpenKernels(), rows);
    // A difference is rounded once, exponentials below exp(-87) are that; the sum, its logarithm
    // and the last addition.
    const auto n = static_cast<double>(rows ? columns : row_count);
    const double bound = 2.0 * range * kUnit + kExpError + Gamma(static_cast<int64_t>(n)) +
                         n * std::exp(-87.0) + 4.0 * kUnit * (range + std::log(n) + 1.0);
    for (const OpenKernels* const kernels : AllOpenSets()) {
      const Tensor<float> out = run(*kernels, rows);
      for (int64_t i = 0; i < out.size(); ++i) {
        ASSERT_LE(std::abs(out[i] - expected[i]), expected[i] == kGuard ? 0.0 : bound)
            << IsaName(kernels->isa) << (rows ? " row " : " column ") << i;
      }
    }
  }
}

TEST(LogSumsTest, AgreeWithTheReference) {
  for (const int64_t rows : {1, 2, 7, 40}) {
    for (const int64_t columns : {1, 3, 15, 16, 17, 100}) {
      CheckLogSums(rows, columns, 5.0F);
      CheckLogSums(rows, columns, 200.0F);
    }
  }
}

// The reference itself.
TEST(LogSumsTest, OfEqualScoresIsTheirLogarithmOfCount) {
  const Tensor<float> scores = Filled(4 * kBlock, 2.0F);
  float sum = 0.0F;
  ReferenceOpenKernels().row_log_sums(
      {.scores = scores.data(), .stride = kBlock, .columns = 5, .row_end = 1, .out = &sum});
  EXPECT_FLOAT_EQ(sum, 2.0F + std::log(5.0F));
  Tensor<float> sums(Shape{kBlock});
  ReferenceOpenKernels().column_log_sums({.scores = scores.data(),
                                          .stride = kBlock,
                                          .rows = 4,
                                          .column_end = kBlock,
                                          .out = sums.data()});
  EXPECT_FLOAT_EQ(sums[7], 2.0F + std::log(4.0F));
}

}  // namespace
}  // namespace gluevo::nn::kernels
