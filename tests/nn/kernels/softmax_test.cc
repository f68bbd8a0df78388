#include <gtest/gtest.h>

#include <cmath>

#include "kernels/kernels.h"
#include "nn/kernels/kernel_test.h"

namespace gluevo::nn::kernels {
namespace {

TEST(DetectorSoftmaxTest, AgreesWithTheReferenceAndPutsPixelsInPlace) {
  constexpr int64_t kColumns = 5;
  constexpr int64_t kRows = 3;
  constexpr int64_t kStride = 80;
  for (const float range : {1.0F, 80.0F}) {
    Tensor<float> logits = Random(kRows * kColumns * kStride, -range, range);
    const auto run = [&](const Kernels& kernels) {
      Tensor<float> scores = Filled(64 * kRows * kColumns, kGuard);
      kernels.detector_softmax({.logits = logits.data(),
                                .stride = kStride,
                                .cell_columns = kColumns,
                                .scores = scores.data(),
                                .cell_row_begin = 1,
                                .cell_row_end = kRows});
      return scores;
    };
    const Tensor<float> expected = run(ReferenceKernels());
    for (const Kernels* const kernels : AllSets()) {
      const Tensor<float> scores = run(*kernels);
      for (int64_t i = 0; i < scores.size(); ++i) {
        // The difference of two logits is rounded once (at most 2 range), the exponential to 1
        // unit; then a sum of 65 and a product.
        const double bound = (2.0 * range * kUnit + 2.0 * kUnit + Gamma(68)) * expected[i];
        ASSERT_LE(std::abs(scores[i] - expected[i]), i < 64 * kColumns ? 0.0 : 2.0 * bound + 1e-37)
            << IsaName(kernels->isa) << " " << i;
      }
    }
  }
  // One clear winner: channel 8 * 2 + 5 of a cell is its pixel (row 2, column 5).
  Tensor<float> logits(Shape{kStride});
  logits[21] = 30.0F;
  Tensor<float> scores(Shape{64});
  ReferenceKernels().detector_softmax({.logits = logits.data(),
                                       .stride = kStride,
                                       .cell_columns = 1,
                                       .scores = scores.data(),
                                       .cell_row_begin = 0,
                                       .cell_row_end = 1});
  EXPECT_NEAR(scores[2 * 8 + 5], 1.0F, 1e-6);
}

TEST(SinkhornRowsTest, AgreesWithTheReference) {
  constexpr int64_t kRows = 9;
  for (const int64_t columns : {1, 2, 7, 8, 9, 15, 16, 17, 33, 301}) {
    const int64_t stride = BlocksOf(columns) * kBlock;
    const Tensor<float> z = Random(kRows * stride, -20.0F, 20.0F);
    const Tensor<float> v = Random(stride, -5.0F, 5.0F);
    const Tensor<float> log_mu = Random(kRows, -7.0F, -1.0F);
    struct Result {
      Tensor<float> u, sums;
    };
    const auto run = [&](const Kernels& kernels) {
      Result result{Tensor<float>(Shape{kRows}), Tensor<float>(Shape{stride})};
      Tensor<float> scratch(Shape{stride});
      kernels.sinkhorn_rows({.z = z.data(),
                             .stride = stride,
                             .columns = columns,
                             .v = v.data(),
                             .log_mu = log_mu.data(),
                             .u = result.u.data(),
                             .column_sums = result.sums.data(),
                             .scratch = scratch.data(),
                             .row_begin = 0,
                             .row_end = kRows});
      return result;
    };
    const Result expected = run(ReferenceKernels());
    // z + v - max is rounded twice at up to 25 and 50; exponentials to 1 unit, sums of `columns`.
    const double relative = 75.0 * kUnit + 2.0 * kUnit + Gamma(columns + kRows + 4);
    for (const Kernels* const kernels : AllSets()) {
      const Result actual = run(*kernels);
      for (int64_t i = 0; i < kRows; ++i) {
        ASSERT_LE(std::abs(actual.u[i] - expected.u[i]), 2.0 * relative + 50.0 * kUnit);
      }
      for (int64_t j = 0; j < columns; ++j) {
        ASSERT_LE(std::abs(actual.sums[j] - expected.sums[j]),
                  3.0 * relative * expected.sums[j] + 1e-37)
            << IsaName(kernels->isa) << " " << columns << " " << j;
      }
    }
  }
}

}  // namespace
}  // namespace gluevo::nn::kernels
