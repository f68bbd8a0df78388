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
        // The difference of two logits is rounded once (at most 2 range); then the exponential, a
        // sum of 65 and a product. Exponents below -87 are taken as that.
        const double bound = (2.0 * range * kUnit + kExpError + Gamma(68)) * expected[i];
        ASSERT_LE(std::abs(scores[i] - expected[i]),
                  i < 64 * kColumns ? 0.0 : 2.0 * bound + std::exp(-87.0))
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

}  // namespace
}  // namespace gluevo::nn::kernels
