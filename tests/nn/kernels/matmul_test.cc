#include <gtest/gtest.h>

#include <cmath>

#include "kernels/kernels.h"
#include "nn/kernels/kernel_test.h"

namespace gluevo::nn::kernels {
namespace {

TEST(MatMulTest, AgreesWithTheReference) {
  for (const int64_t rows : {1, 2, 5, 6, 7, 13, 14, 29, 43, 50}) {
    for (const int64_t columns : {1, 7, 16, 17, 32, 65, 100}) {
      for (const int variant : {0, 1, 2, 3}) {
        SCOPED_TRACE(testing::Message() << rows << "x" << columns << " variant " << variant);
        const int64_t k0 = variant == 2 ? 32 : 19;
        const int64_t k1 = variant == 1 ? 33 : 0;
        const int64_t stride = columns + 3;
        const bool blocked = variant == 2;
        const Tensor<float> a0 = Random(rows * (k0 + 1));
        const Tensor<float> a1 = Random(rows * (k1 + 2));
        const Tensor<float> weights = Random(columns * (k0 + k1));
        Tensor<float> b(Shape{PackedMatrixFloats(columns, k0 + k1)});
        PackMatrix(weights.data(), k0 + k1, columns, k0 + k1, b.data());
        const Tensor<float> bias = Random(BlocksOf(columns) * kBlock);
        const Tensor<float> residual = Random(rows * stride);
        const auto run = [&](const Kernels& kernels, const Tensor<float>& left0,
                             const Tensor<float>& left1, const Tensor<float>& right,
                             const Tensor<float>& offset, bool relu, Tensor<float>& c) {
          MatMul p{.a0 = left0.data(),
                   .a0_stride = blocked ? kBlock : k0 + 1,
                   .a0_block_stride = blocked ? rows * kBlock : kBlock,
                   .k0 = k0,
                   .a1 = left1.data(),
                   .a1_stride = k1 + 2,
                   .k1 = k1,
                   .b = right.data(),
                   .bias = variant == 3 ? nullptr : offset.data(),
                   .relu = relu,
                   .residual = variant == 1 ? c.data() : nullptr,
                   .c = c.data(),
                   .c_stride = stride,
                   .columns = columns};
          p.row_end = rows / 3;
          kernels.matmul(p);
          p.row_begin = rows / 3;
          p.row_end = rows;
          kernels.matmul(p);
        };
        Tensor<float> expected = residual;
        run(ReferenceKernels(), a0, a1, b, bias, variant == 0, expected);
        Tensor<float> magnitude = Absolute(residual);
        run(ReferenceKernels(), Absolute(a0), Absolute(a1), Absolute(b), Absolute(bias), false,
            magnitude);
        for (const Kernels* const kernels : AllSets()) {
          SCOPED_TRACE(IsaName(kernels->isa));
          Tensor<float> c = residual;
          run(*kernels, a0, a1, b, bias, variant == 0, c);
          for (int64_t i = 0; i < c.size(); ++i) {
            const double bound = i % stride < columns ? Gamma(k0 + k1 + 3) * magnitude[i] : 0.0;
            ASSERT_LE(std::abs(c[i] - expected[i]), bound) << i;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace gluevo::nn::kernels
