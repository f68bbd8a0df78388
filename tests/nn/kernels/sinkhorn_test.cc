#include <gtest/gtest.h>

#include <cmath>

#include "kernels/kernels.h"
#include "nn/kernels/kernel_test.h"

namespace gluevo::nn::kernels {
namespace {

constexpr int64_t kRows = 9;

TEST(SinkhornExponentialsTest, AgreesWithTheReference) {
  for (const int64_t columns : {1, 2, 7, 8, 9, 15, 16, 17, 33, 301}) {
    const int64_t stride = BlocksOf(columns) * kBlock;
    const Tensor<float> z = Random(kRows * stride, -60.0F, 60.0F);
    const Tensor<float> u = Random(kRows, -30.0F, -10.0F);
    const Tensor<float> v = Random(stride, -5.0F, 5.0F);
    const auto run = [&](const Kernels& kernels) {
      Tensor<float> k = Filled(kRows * stride, kGuard);
      kernels.sinkhorn_exponentials({.z = z.data(),
                                     .stride = stride,
                                     .columns = columns,
                                     .u = u.data(),
                                     .v = v.data(),
                                     .k = k.data(),
                                     .row_begin = 1,
                                     .row_end = kRows});
      return k;
    };
    const Tensor<float> expected = run(ReferenceKernels());
    for (const Kernels* const kernels : AllSets()) {
      const Tensor<float> k = run(*kernels);
      for (int64_t i = 0; i < k.size(); ++i) {
        // Two sums, rounded at up to 95; next to -80, either side of the limit.
        const double relative = 2.0 * 95.0 * kUnit + kExpError;
        ASSERT_LE(std::abs(k[i] - expected[i]),
                  i < stride ? 0.0 : 2.0 * relative * expected[i] + 1.01 * std::exp(-80.0))
            << IsaName(kernels->isa) << " " << i;
        if (i % stride >= columns && i >= stride) {
          ASSERT_EQ(k[i], 0.0F);
        }
      }
    }
  }
}

TEST(SinkhornRowsTest, AgreesWithTheReference) {
  for (const int64_t stride : {16, 32, 304}) {
    Tensor<float> k = Random(kRows * stride, 0.0F, 1.0F);
    std::fill_n(k.data() + 4 * stride, stride, 0.0F);  // A row that has vanished.
    const Tensor<float> b = Random(stride, 0.01F, 3.0F);
    const Tensor<float> mu = Random(kRows, 0.5F, 2.0F);
    struct Result {
      Tensor<float> a, sums;
    };
    const auto run = [&](const Kernels& kernels) {
      Result result{Filled(kRows, kGuard), Filled(stride, 1.0F)};
      kernels.sinkhorn_rows({.k = k.data(),
                             .stride = stride,
                             .b = b.data(),
                             .mu = mu.data(),
                             .a = result.a.data(),
                             .column_sums = result.sums.data(),
                             .row_begin = 1,
                             .row_end = kRows});
      return result;
    };
    const Result expected = run(ReferenceKernels());
    EXPECT_GT(expected.a[4], 1e37F);
    for (const Kernels* const kernels : AllSets()) {
      const Result actual = run(*kernels);
      EXPECT_EQ(actual.a[0], kGuard);
      for (int64_t i = 1; i < kRows; ++i) {
        ASSERT_LE(std::abs(actual.a[i] / expected.a[i] - 1.0), Gamma(stride + 3));
      }
      for (int64_t j = 0; j < stride; ++j) {
        ASSERT_LE(std::abs(actual.sums[j] / expected.sums[j] - 1.0), Gamma(stride + 2 * kRows + 5))
            << IsaName(kernels->isa) << " " << j;
      }
    }
  }
}

}  // namespace
}  // namespace gluevo::nn::kernels
