#include "kernels/kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "gluevo/nn/tensor.h"
#include "kernels/reference.h"
#include "kernels/vectorized.h"

// Every kernel on every instruction set against the reference. A sum of n products in floats errs
// by at most gamma_n times the sum of their absolute values, gamma_n = n u / (1 - n u), u = 2^-24
// (Higham 2002, section 3.1), in whatever order and with or without fused multiply-adds: the bound
// of each output comes from a run of the reference on absolute values.
namespace gluevo::nn::kernels {
namespace {

constexpr double kUnit = 0x1p-24;
// Outside of what a kernel may write.
constexpr float kGuard = 1234.5F;

double Gamma(int64_t n) { return static_cast<double>(n) * kUnit / (1.0 - n * kUnit); }

std::vector<const Kernels*> AllSets() {
  std::vector<const Kernels*> sets = VectorizedKernels();
  sets.push_back(&ScalarKernels());
  return sets;
}

std::mt19937& Generator() {
  static std::mt19937 generator(7);
  return generator;
}

Tensor<float> Random(int64_t size, float low = -1.0F, float high = 1.0F) {
  Tensor<float> tensor(Shape{size});
  std::uniform_real_distribution<float> uniform(low, high);
  for (int64_t i = 0; i < size; ++i) {
    tensor[i] = uniform(Generator());
  }
  return tensor;
}

Tensor<float> Filled(int64_t size, float value) {
  Tensor<float> tensor(Shape{size});
  std::fill_n(tensor.data(), size, value);
  return tensor;
}

Tensor<float> Absolute(const Tensor<float>& tensor) {
  Tensor<float> result(tensor.shape());
  result.view().Vector() = tensor.view().Vector().cwiseAbs();
  return result;
}

struct ConvCase {
  int64_t in_channels, out_channels, height, width;
  bool relu, pool;
};

void CheckConv(const ConvCase& c) {
  SCOPED_TRACE(testing::Message() << c.in_channels << "->" << c.out_channels << " at " << c.width
                                  << "x" << c.height << " relu " << c.relu << " pool " << c.pool);
  const bool gray = c.in_channels == 1;
  const int64_t in_blocks = BlocksOf(c.in_channels);
  const int64_t out_blocks = BlocksOf(c.out_channels);
  const int64_t in_size =
      gray ? (c.height + 2) * (c.width + 2) : BlockedMap::Floats(in_blocks, c.height, c.width);
  Tensor<float> in = Random(in_size);
  if (!gray) {
    ClearHalo({in.data(), in_blocks, c.height, c.width});
  }
  const Tensor<float> weights = Random(c.out_channels * c.in_channels * 9);
  Tensor<float> packed(Shape{PackedConv3x3Floats(c.out_channels, c.in_channels)});
  PackConv3x3(weights.data(), c.out_channels, c.in_channels, packed.data());
  Tensor<float> bias(Shape{out_blocks * kBlock});
  std::copy_n(Random(c.out_channels).data(), c.out_channels, bias.data());

  const int64_t out_height = c.pool ? c.height / 2 : c.height;
  const int64_t out_width = c.pool ? c.width / 2 : c.width;
  const int64_t out_size = BlockedMap::Floats(out_blocks, out_height, out_width);
  const auto run = [&](const Kernels& kernels, Tensor<float>& source, const Tensor<float>& w,
                       const Tensor<float>& b, Tensor<float>& out, bool relu) {
    Conv3x3 p{.in = {source.data(), in_blocks, c.height, c.width},
              .gray = gray,
              .weights = w.data(),
              .bias = b.data(),
              .relu = relu,
              .pool = c.pool,
              .out = {out.data(), out_blocks, out_height, out_width}};
    // In two parts, as threads do.
    p.row_begin = 0;
    p.row_end = out_height / 2;
    kernels.conv3x3(p);
    p.row_begin = p.row_end;
    p.row_end = out_height;
    kernels.conv3x3(p);
  };
  Tensor<float> expected = Filled(out_size, kGuard);
  run(ReferenceKernels(), in, packed, bias, expected, c.relu);
  Tensor<float> magnitude = Filled(out_size, 0.0F);
  Tensor<float> absolute_in = Absolute(in);
  run(ReferenceKernels(), absolute_in, Absolute(packed), Absolute(bias), magnitude, false);
  for (const Kernels* const kernels : AllSets()) {
    SCOPED_TRACE(IsaName(kernels->isa));
    Tensor<float> out = Filled(out_size, kGuard);
    run(*kernels, in, packed, bias, out, c.relu);
    for (int64_t i = 0; i < out_size; ++i) {
      // The halo holds the guard in both, and a magnitude of 0.
      ASSERT_LE(std::abs(out[i] - expected[i]), Gamma(9 * c.in_channels + 3) * magnitude[i]) << i;
    }
  }
  // The reference itself, against the definition on unpacked weights.
  if (!gray && !c.pool && c.height * c.width < 200) {
    const BlockedMap map{in.data(), in_blocks, c.height, c.width};
    const BlockedMap out{expected.data(), out_blocks, out_height, out_width};
    const int64_t y = c.height / 2;
    const int64_t x = c.width - 1;
    for (int64_t o = 0; o < c.out_channels; ++o) {
      double sum = bias[o];
      for (int64_t i = 0; i < c.in_channels; ++i) {
        for (int64_t tap = 0; tap < 9; ++tap) {
          sum += static_cast<double>(weights[(o * c.in_channels + i) * 9 + tap]) *
                 map.pixel(i / kBlock, y + tap / 3 - 1, x + tap % 3 - 1)[i % kBlock];
        }
      }
      sum = c.relu ? std::max(sum, 0.0) : sum;
      EXPECT_FLOAT_EQ(out.pixel(o / kBlock, y, x)[o % kBlock], static_cast<float>(sum));
    }
  }
}

TEST(Conv3x3Test, AgreesWithTheReference) {
  for (const int64_t width : {2, 3, 5, 6, 7, 13, 14, 15, 31, 83, 85, 170}) {
    for (const int64_t height : {2, 3, 5}) {
      for (const bool pool : {false, true}) {
        CheckConv({1, 20, height, width, true, pool});
        CheckConv({16, 16, height, width, false, pool});
        CheckConv({20, 33, height, width, true, pool});
      }
    }
  }
  CheckConv({1, 16, 1, 1, true, false});
  CheckConv({48, 80, 4, 9, true, false});
  CheckConv({128, 64, 3, 20, true, true});
}

TEST(Conv3x3Test, HaloRowsCanBeComputedToo) {
  // The first layer writes the rows above and below a band: row_begin is -1.
  const int64_t width = 17;
  const Tensor<float> plane = Random(10 * (width + 2));
  Tensor<float> packed(Shape{PackedConv3x3Floats(16, 1)});
  PackConv3x3(Random(16 * 9).data(), 16, 1, packed.data());
  const Tensor<float> bias = Random(16);
  const auto run = [&](const Kernels& kernels) {
    Tensor<float> out = Filled(BlockedMap::Floats(1, 4, width), 0.0F);
    kernels.conv3x3({.in = {const_cast<float*>(plane.data()) + 2 * (width + 2), 1, 8, width},
                     .gray = true,
                     .weights = packed.data(),
                     .bias = bias.data(),
                     .out = {out.data(), 1, 4, width},
                     .row_begin = -1,
                     .row_end = 5});
    return out;
  };
  const Tensor<float> expected = run(ReferenceKernels());
  EXPECT_NE(expected[kBlock], 0.0F);
  for (const Kernels* const kernels : AllSets()) {
    const Tensor<float> out = run(*kernels);
    for (int64_t i = 0; i < out.size(); ++i) {
      // Nine products of values below 1, and a bias.
      ASSERT_LE(std::abs(out[i] - expected[i]), Gamma(12) * 10.0) << IsaName(kernels->isa);
    }
  }
}

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

TEST(AttentionTest, AgreesWithTheReference) {
  for (const int64_t keys : {1, 2, 15, 16, 17, 70, 300}) {
    for (const int64_t head_dim : {4, 8, 20, 64}) {
      SCOPED_TRACE(testing::Message() << keys << " keys of " << head_dim);
      constexpr int64_t kQueries = 37;
      const int64_t value_size = BlocksOf(head_dim) * kBlock;
      const int64_t stride = head_dim + 5;
      const Tensor<float> q = Random(kQueries * stride);
      const Tensor<float> k = Random(keys * head_dim, -2.0F, 2.0F);
      Tensor<float> packed(Shape{PackedMatrixFloats(keys, head_dim)});
      PackMatrix(k.data(), head_dim, keys, head_dim, packed.data());
      Tensor<float> v = Random(keys * value_size);
      const auto run = [&](const Kernels& kernels) {
        Tensor<float> out = Filled(kQueries * stride, kGuard);
        Tensor<float> scratch(Shape{AttentionScratchFloats(keys)});
        Attention p{.q = q.data(),
                    .q_stride = stride,
                    .k_packed = packed.data(),
                    .v = v.data(),
                    .keys = keys,
                    .head_dim = head_dim,
                    .out = out.data(),
                    .out_stride = stride,
                    .row_begin = 1,
                    .row_end = kQueries,
                    .scratch = scratch.data()};
        kernels.attention(p);
        return out;
      };
      const Tensor<float> expected = run(ReferenceKernels());
      // A score errs by gamma_d sum |q k| <= gamma_d 2 d, as does its distance from the largest;
      // hn::Exp is documented to 1 unit in the last place; then a sum of `keys` weights and one of
      // `keys` products of weights and values below 1.
      const double score_error = 2.0 * Gamma(head_dim + 1) * 2.0 * head_dim;
      const double bound = 2.0 * (score_error + 2.0 * kUnit) + 2.0 * Gamma(keys + 3);
      for (const Kernels* const kernels : AllSets()) {
        const Tensor<float> out = run(*kernels);
        for (int64_t i = 0; i < out.size(); ++i) {
          const bool written = i >= stride && i % stride < head_dim;
          ASSERT_LE(std::abs(out[i] - expected[i]), written ? bound : 0.0)
              << IsaName(kernels->isa) << " " << i;
        }
      }
    }
  }
}

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

TEST(IsaTest, TheEnvironmentChoosesAndAnUnknownSetIsRefused) {
  for (const Isa isa : SupportedIsas()) {
    setenv("GLUEVO_ISA", IsaName(isa).c_str(), 1);
    EXPECT_EQ(ChooseIsa(), isa);
  }
  setenv("GLUEVO_ISA", "neon9", 1);
  try {
    ChooseIsa();
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("GLUEVO_ISA=neon9"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("portable"), std::string::npos);
  }
  unsetenv("GLUEVO_ISA");
  EXPECT_EQ(ChooseIsa(), SupportedIsas().back());
}

}  // namespace
}  // namespace gluevo::nn::kernels
