#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "gluevo/nn/elements.h"
#include "kernels/bf16.h"
#include "kernels/kernels.h"
#include "nn/kernels/kernel_test.h"

namespace gluevo::nn::kernels {
namespace {

// Channels [row][channel] as a left operand.
template <typename Element>
Tensor<Element> LeftOperand(const Tensor<float>& rows, int64_t count, int64_t channels) {
  Tensor<Element> operand(Shape{ElementBlocks<Element>(channels) * count * kBlock});
  for (int64_t row = 0; row < count; ++row) {
    for (int64_t i = 0; i < channels; ++i) {
      const int64_t element = i / kChannelsPer<Element>;
      Element& at = operand[(element / kBlock * count + row) * kBlock + element % kBlock];
      if constexpr (kChannelsPer<Element> == 1) {
        at = rows[row * channels + i];
      } else {
        (i % 2 == 0 ? at.low : at.high) = ToBf16(rows[row * channels + i]);
      }
    }
  }
  return operand;
}

struct Case {
  int64_t rows, columns, k0, k1;
  bool bias, relu, residual;
};

// A product with random operands, and the same with their absolute values.
template <typename Element>
class Problem {
 public:
  explicit Problem(const Case& c) : case_(c), c_(Random(c.rows * Stride())) {
    const Tensor<float> a0 = Random(c.rows * c.k0);
    const Tensor<float> a1 = Random(c.rows * c.k1);
    // Of the second part, the weights begin at a whole block.
    const int64_t depth0 = ElementBlocks<Element>(c.k0) * kBlock * kChannelsPer<Element>;
    Tensor<float> weights(Shape{c.columns * (depth0 + c.k1)});
    for (int64_t column = 0; column < c.columns; ++column) {
      std::copy_n(Random(c.k0).data(), c.k0, weights.data() + column * (depth0 + c.k1));
      std::copy_n(Random(c.k1).data(), c.k1, weights.data() + column * (depth0 + c.k1) + depth0);
    }
    const Tensor<float> bias = Random(BlocksOf(c.columns) * kBlock);
    for (const bool absolute : {false, true}) {
      const auto values = [&](const Tensor<float>& t) { return absolute ? Absolute(t) : t; };
      Operands& operands = absolute ? absolute_ : exact_;
      operands.a0 = LeftOperand<Element>(values(a0), c.rows, c.k0);
      operands.a1 = LeftOperand<Element>(values(a1), c.rows, c.k1);
      operands.b = Tensor<Element>(Shape{PackedMatrixSize<Element>(c.columns, depth0 + c.k1)});
      PackMatrix(values(weights).data(), depth0 + c.k1, c.columns, depth0 + c.k1,
                 operands.b.data());
      operands.bias = values(bias);
      operands.c = values(c_);
    }
  }

  int64_t Stride() const { return case_.columns + 3; }
  int64_t RoundedSize() const {
    return (case_.columns + 2 * kBlock - 1) / (2 * kBlock) * case_.rows * kBlock;
  }

  struct Result {
    Tensor<float> c;
    Tensor<Bf16Pair> rounded;
  };
  // In two parts, as threads do.
  Result Run(const Kernels& kernels, bool absolute) const {
    const Operands& operands = absolute ? absolute_ : exact_;
    Result result{operands.c, Tensor<Bf16Pair>(Shape{RoundedSize()})};
    for (const auto& [begin, end] :
         {std::pair<int64_t, int64_t>{0, case_.rows / 3}, {case_.rows / 3, case_.rows}}) {
      Multiply<Element>(kernels,
                        {.a0 = operands.a0.data() + begin * kBlock,
                         .a0_block_stride = case_.rows * kBlock,
                         .a0_blocks = ElementBlocks<Element>(case_.k0),
                         .a1 = operands.a1.data() + begin * kBlock,
                         .a1_block_stride = case_.rows * kBlock,
                         .a1_blocks = ElementBlocks<Element>(case_.k1),
                         .b = operands.b.data(),
                         .bias = case_.bias ? operands.bias.data() : nullptr,
                         .relu = case_.relu && !absolute,
                         .residual = case_.residual ? result.c.data() + begin * Stride() : nullptr,
                         .c = result.c.data() + begin * Stride(),
                         .c_stride = Stride(),
                         .c_block_stride = kBlock,
                         .rounded = result.rounded.data() + begin * kBlock,
                         .rounded_block_stride = case_.rows * kBlock,
                         .columns = case_.columns,
                         .rows = end - begin});
    }
    return result;
  }

 private:
  struct Operands {
    Tensor<Element> a0, a1, b;
    Tensor<float> bias, c;
  };
  Case case_;
  Tensor<float> c_;
  Operands exact_, absolute_;
};

template <typename Element>
void Check(const Case& c) {
  SCOPED_TRACE(testing::Message() << c.rows << "x" << c.columns << " of " << c.k0 << "+" << c.k1
                                  << (kChannelsPer<Element> == 1 ? " float" : " bf16"));
  const Problem<Element> problem(c);
  const auto expected = problem.Run(ReferenceKernels(), false);
  const auto magnitude = problem.Run(ReferenceKernels(), true);
  // Products of two bf16 are exact in a float, but count as a rounding.
  const double gamma = Gamma(2 * (c.k0 + c.k1) + 3);
  for (const Kernels* const kernels : AllSets()) {
    SCOPED_TRACE(IsaName(kernels->isa));
    const auto result = problem.Run(*kernels, false);
    for (int64_t row = 0; row < c.rows; ++row) {
      for (int64_t column = 0; column < problem.Stride(); ++column) {
        const int64_t at = row * problem.Stride() + column;
        const double bound = column < c.columns ? gamma * magnitude.c[at] : 0.0;
        ASSERT_LE(std::abs(result.c[at] - expected.c[at]), bound) << row << ", " << column;
        if (column < c.columns) {
          const Bf16Pair& pair = result.rounded[(column / (2 * kBlock) * c.rows + row) * kBlock +
                                                column % (2 * kBlock) / 2];
          ASSERT_EQ(column % 2 == 0 ? pair.low : pair.high, ToBf16(result.c[at]))
              << row << ", " << column;
        }
      }
    }
  }
}

TEST(MatMulTest, AgreesWithTheReference) {
  for (const int64_t rows : {1, 2, 5, 6, 7, 13, 14, 29, 43, 57, 70}) {
    for (const int64_t columns : {1, 7, 16, 17, 32, 65, 100}) {
      const Case c = {.rows = rows,
                      .columns = columns,
                      .k0 = 19 + rows,
                      .k1 = columns % 2 == 0 ? 33 : 0,
                      .bias = columns != 7,
                      .relu = rows % 2 == 0,
                      .residual = columns % 3 == 0};
      Check<float>(c);
      Check<Bf16Pair>(c);
    }
  }
}

// The reference itself, against the definition.
TEST(MatMulTest, TheReferenceIsAProduct) {
  constexpr int64_t kRows = 3;
  constexpr int64_t kIn = 5;
  constexpr int64_t kOut = 18;
  const Tensor<float> rows = Random(kRows * kIn);
  const Tensor<float> weights = Random(kOut * kIn);
  const Tensor<float> a = LeftOperand<float>(rows, kRows, kIn);
  Tensor<float> b(Shape{PackedMatrixSize<float>(kOut, kIn)});
  PackMatrix(weights.data(), kIn, kOut, kIn, b.data());
  Tensor<float> c(Shape{kRows * kOut});
  ReferenceKernels().matmul({.a0 = a.data(),
                             .a0_block_stride = kRows * kBlock,
                             .a0_blocks = 1,
                             .b = b.data(),
                             .c = c.data(),
                             .c_stride = kOut,
                             .c_block_stride = kBlock,
                             .columns = kOut,
                             .rows = kRows});
  for (int64_t row = 0; row < kRows; ++row) {
    for (int64_t column = 0; column < kOut; ++column) {
      double sum = 0.0;
      for (int64_t i = 0; i < kIn; ++i) {
        sum += static_cast<double>(rows[row * kIn + i]) * weights[column * kIn + i];
      }
      EXPECT_FLOAT_EQ(c[row * kOut + column], static_cast<float>(sum));
    }
  }
}

TEST(PackRowsTest, IsTheTransposeOfEachBlockOfRows) {
  constexpr int64_t kRows = 21;
  const Tensor<float> rows = Random(2 * kRows * kBlock);
  Tensor<float> packed = Filled(2 * 2 * kBlock * kBlock, kGuard);
  PackRows(rows.data(), kRows * kBlock, 2, kRows, packed.data());
  for (int64_t row = 0; row < 2 * kBlock; ++row) {
    for (int64_t channel = 0; channel < 2 * kBlock; ++channel) {
      const float expected =
          row < kRows ? rows[(channel / kBlock * kRows + row) * kBlock + channel % kBlock] : 0.0F;
      EXPECT_EQ(packed[(row / kBlock * 2 * kBlock + channel) * kBlock + row % kBlock], expected);
    }
  }
}

TEST(Bf16Test, RoundsToTheNearestTiesToEven) {
  EXPECT_EQ(Bfloat16ToFloat(ToBf16(1.0F)), 1.0F);
  EXPECT_EQ(Bfloat16ToFloat(ToBf16(-1.5F)), -1.5F);
  EXPECT_EQ(Bfloat16ToFloat(ToBf16(1.0F + 0x1p-8F)), 1.0F);                // A tie, 1 is even.
  EXPECT_EQ(Bfloat16ToFloat(ToBf16(1.0F + 3 * 0x1p-8F)), 1.0F + 0x1p-6F);  // A tie, up to even.
  EXPECT_EQ(Bfloat16ToFloat(ToBf16(1.0F + 0x1.02p-8F)), 1.0F + 0x1p-7F);
}

}  // namespace
}  // namespace gluevo::nn::kernels
