#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/open_kernels.h"
#include "nn/kernels/kernel_test.h"
#include "nn/kernels/open_kernel_test.h"

namespace gluevo::nn::kernels {
namespace {

// Of SELU at x: what its exponential errs by, and a product and a sum.
double SeluError(double x) {
  const double slope = kSeluScale * kSeluAlpha;
  return slope * (kExpError + Gamma(3)) + 2.0 * Gamma(3) * kSeluScale * std::abs(x);
}

TEST(SeluTest, AgreesWithTheReference) {
  constexpr int64_t kCount = 1024 * kBlock;
  for (const bool with_addend : {false, true}) {
    const Tensor<float> start = Random(kCount, -20.0F, 20.0F);
    const Tensor<float> addend = Random(kCount, -20.0F, 20.0F);
    const auto run = [&](const OpenKernels& kernels) {
      Tensor<float> values = start;
      kernels.selu({.values = values.data(),
                    .addend = with_addend ? addend.data() : nullptr,
                    .count = kCount - kBlock});
      return values;
    };
    const Tensor<float> expected = run(ReferenceOpenKernels());
    for (const OpenKernels* const kernels : AllOpenSets()) {
      const Tensor<float> values = run(*kernels);
      for (int64_t i = 0; i < kCount; ++i) {
        const double size = std::abs(start[i]) + (with_addend ? std::abs(addend[i]) : 0.0);
        ASSERT_LE(std::abs(values[i] - expected[i]),
                  i < kCount - kBlock ? SeluError(size) + 2.0 * kUnit * size : 0.0)
            << IsaName(kernels->isa) << " " << start[i];
      }
    }
  }
}

// A map of random values with zeros around it.
Tensor<float> RandomMap(int64_t blocks, int64_t height, int64_t width) {
  Tensor<float> values = Random(BlockedMap::Floats(blocks, height, width));
  ClearHalo({values.data(), blocks, height, width});
  return values;
}

TEST(AveragePoolTest, AgreesWithTheReference) {
  for (const int64_t size : {1, 2, 4}) {
    for (const int64_t blocks : {1, 3}) {
      constexpr int64_t kHeight = 5;
      constexpr int64_t kWidth = 7;
      Tensor<float> in = RandomMap(blocks, kHeight * size, kWidth * size);
      const auto run = [&](const OpenKernels& kernels) {
        Tensor<float> out = Filled(BlockedMap::Floats(blocks, kHeight, kWidth), kGuard);
        kernels.average_pool({.in = {in.data(), blocks, kHeight * size, kWidth * size},
                              .size = size,
                              .out = {out.data(), blocks, kHeight, kWidth},
                              .row_begin = 1,
                              .row_end = 4,
                              .column_begin = 2,
                              .column_end = 7});
        return out;
      };
      const Tensor<float> expected = run(ReferenceOpenKernels());
      for (const OpenKernels* const kernels : AllOpenSets()) {
        const Tensor<float> out = run(*kernels);
        for (int64_t i = 0; i < out.size(); ++i) {
          ASSERT_LE(std::abs(out[i] - expected[i]),
                    expected[i] == kGuard ? 0.0 : Gamma(size * size + 2))
              << IsaName(kernels->isa) << " " << size << " " << i;
        }
      }
    }
  }
}

// The reference itself.
TEST(AveragePoolTest, IsTheMean) {
  Tensor<float> in(Shape{BlockedMap::Floats(1, 2, 2)});
  const BlockedMap map{in.data(), 1, 2, 2};
  map.pixel(0, 0, 0)[3] = 1.0F;
  map.pixel(0, 1, 1)[3] = 4.0F;
  Tensor<float> out(Shape{BlockedMap::Floats(1, 1, 1)});
  const BlockedMap to{out.data(), 1, 1, 1};
  ReferenceOpenKernels().average_pool(
      {.in = map, .size = 2, .out = to, .row_end = 1, .column_end = 1});
  EXPECT_FLOAT_EQ(to.pixel(0, 0, 0)[3], 1.25F);
}

void CheckDeformableRows(int64_t blocks, int64_t height, int64_t width, float range) {
  SCOPED_TRACE(testing::Message() << blocks << " blocks of " << width << " x " << height << ", "
                                  << range);
  Tensor<float> in = RandomMap(blocks, height, width);
  Tensor<float> offsets = Random(BlockedMap::Floats(2, height, width), -range, range);
  const BlockedMap offset_map{offsets.data(), 2, height, width};
  // Some on whole pixels, and exactly at and beyond the border.
  for (int64_t tap = 0; tap < 9; ++tap) {
    offset_map.pixel(2 * tap / kBlock, 0, 0)[2 * tap % kBlock] = static_cast<float>(tap % 4 - 2);
  }
  const int64_t count = std::min<int64_t>(width, 6);
  const int64_t stride = (count + 1) * kBlock;
  const auto run = [&](const OpenKernels& kernels, int64_t y, int64_t x) {
    Tensor<float> rows = Filled(9 * blocks * stride, kGuard);
    kernels.deformable_rows({.in = {in.data(), blocks, height, width},
                             .offsets = offset_map,
                             .limit = 2.5F,
                             .y = y,
                             .x_begin = x,
                             .count = count,
                             .rows = rows.data(),
                             .block_stride = stride});
    return rows;
  };
  for (int64_t y = 0; y < height; ++y) {
    for (const int64_t x : {int64_t{0}, width - count}) {
      const Tensor<float> expected = run(ReferenceOpenKernels(), y, x);
      for (const OpenKernels* const kernels : AllOpenSets()) {
        const Tensor<float> rows = run(*kernels, y, x);
        for (int64_t i = 0; i < rows.size(); ++i) {
          // A position is rounded to a unit of its size on both axes, between pixels that differ by
          // at most 2; then two steps of interpolation.
          const double position = static_cast<double>(std::max(height, width)) + 3.5;
          ASSERT_LE(std::abs(rows[i] - expected[i]),
                    expected[i] == kGuard ? 0.0 : 2.0 * 2.0 * 2.0 * kUnit * position + 2 * Gamma(6))
              << IsaName(kernels->isa) << " " << y << " " << x << " " << i;
        }
      }
    }
  }
}

TEST(DeformableRowsTest, AgreeWithTheReference) {
  for (const float range : {0.0F, 1.0F, 5.0F}) {
    CheckDeformableRows(1, 1, 1, range);
    CheckDeformableRows(1, 4, 5, range);
    CheckDeformableRows(2, 6, 11, range);
    CheckDeformableRows(4, 3, 28, range);
  }
}

// The reference itself: dy is the first of a tap's two channels, and samples fade to zero outside.
TEST(DeformableRowsTest, OffsetsAreRowsThenColumns) {
  Tensor<float> in(Shape{BlockedMap::Floats(1, 4, 4)});
  const BlockedMap map{in.data(), 1, 4, 4};
  map.pixel(0, 3, 1)[2] = 8.0F;
  Tensor<float> offsets(Shape{BlockedMap::Floats(2, 4, 4)});
  const BlockedMap offset_map{offsets.data(), 2, 4, 4};
  const auto center = [&](float dy, float dx) {
    offset_map.pixel(0, 1, 1)[8] = dy;
    offset_map.pixel(0, 1, 1)[9] = dx;
    Tensor<float> rows(Shape{9 * kBlock});
    ReferenceOpenKernels().deformable_rows({.in = map,
                                            .offsets = offset_map,
                                            .limit = 3.0F,
                                            .y = 1,
                                            .x_begin = 1,
                                            .count = 1,
                                            .rows = rows.data(),
                                            .block_stride = kBlock});
    return rows[4 * kBlock + 2];
  };
  EXPECT_FLOAT_EQ(center(2.0F, 0.0F), 8.0F);
  EXPECT_FLOAT_EQ(center(2.0F, 0.25F), 6.0F);
  EXPECT_FLOAT_EQ(center(2.5F, 0.0F), 4.0F);  // Half way to the zeros below.
  EXPECT_FLOAT_EQ(center(5.0F, 0.0F), 0.0F);  // Clamped to 3: on the zeros.
  EXPECT_FLOAT_EQ(center(0.0F, 2.0F), 0.0F);
}

// Maps of three sizes and the taps between them and 32 x 48 pixels.
struct CoarseMaps {
  explicit CoarseMaps(int64_t blocks) {
    for (std::size_t i = 0; i < 3; ++i) {
      const int64_t height = kHeight / (i == 0 ? 2 : i == 1 ? 8 : 32);
      const int64_t width = kWidth / (i == 0 ? 2 : 8);
      values.push_back(RandomMap(blocks, height, width));
      maps[i] = {values.back().data(), blocks, height, width};
      taps_y[i] = Taps(height, kHeight);
      taps_x[i] = Taps(width, kWidth);
    }
  }
  static std::vector<AlignedTap> Taps(int64_t from, int64_t to) {
    std::vector<AlignedTap> taps;
    taps.reserve(static_cast<std::size_t>(to));
    for (int64_t i = 0; i < to; ++i) {
      const float at =
          static_cast<float>(i) * static_cast<float>(from - 1) / static_cast<float>(to - 1);
      const auto low = static_cast<int32_t>(at);
      taps.push_back(
          {low, std::min(low + 1, static_cast<int32_t>(from) - 1), at - static_cast<float>(low)});
    }
    return taps;
  }

  static constexpr int64_t kHeight = 32;
  static constexpr int64_t kWidth = 48;
  std::vector<Tensor<float>> values;
  BlockedMap maps[3];
  std::vector<AlignedTap> taps_y[3];
  std::vector<AlignedTap> taps_x[3];
};

TEST(FeatureRowsTest, AgreeWithTheReference) {
  for (const int64_t group_blocks : {1, 2}) {
    const CoarseMaps coarse(group_blocks);
    for (const int64_t count : {1, 5, 28}) {
      const int64_t stride = (count + 1) * kBlock;
      std::vector<int32_t> ys;
      std::vector<int32_t> xs;
      ys.reserve(static_cast<std::size_t>(count));
      xs.reserve(static_cast<std::size_t>(count));
      for (int64_t i = 0; i < count; ++i) {
        ys.push_back(static_cast<int32_t>(i * 37 % CoarseMaps::kHeight));
        xs.push_back(static_cast<int32_t>((i * 29 + 47) % CoarseMaps::kWidth));
      }
      const Tensor<float> start = Random(4 * group_blocks * stride);
      const auto run = [&](const OpenKernels& kernels) {
        Tensor<float> rows = start;
        FeatureRows p = {.rows = rows.data(),
                         .block_stride = stride,
                         .group_blocks = group_blocks,
                         .pixels_y = ys.data(),
                         .pixels_x = xs.data(),
                         .count = count};
        for (int i = 0; i < 3; ++i) {
          p.maps[i] = coarse.maps[i];
          p.taps_y[i] = coarse.taps_y[i].data();
          p.taps_x[i] = coarse.taps_x[i].data();
        }
        kernels.feature_rows(p);
        return rows;
      };
      const Tensor<float> expected = run(ReferenceOpenKernels());
      // Unit length: every value errs by what SELU or interpolation errs over the length, and by
      // what the length does.
      for (int64_t row = 0; row < count; ++row) {
        double length = 0.0;
        for (int64_t block = 0; block < 4 * group_blocks; ++block) {
          for (int64_t c = 0; c < kBlock; ++c) {
            const double value = expected[block * stride + row * kBlock + c];
            length += value * value;
          }
        }
        EXPECT_NEAR(length, 1.0, 1e-6);
      }
      // The raw length is at least that of one group of 16 SELUs of random numbers; 1 is below it.
      const double bound =
          2.0 * (SeluError(1.0) + 2.0 * Gamma(6)) + Gamma(4 * group_blocks * kBlock + 6);
      for (const OpenKernels* const kernels : AllOpenSets()) {
        const Tensor<float> rows = run(*kernels);
        for (int64_t i = 0; i < rows.size(); ++i) {
          const bool outside = i % stride >= count * kBlock;
          ASSERT_LE(std::abs(rows[i] - expected[i]), outside ? 0.0 : bound)
              << IsaName(kernels->isa) << " " << i;
          ASSERT_TRUE(!outside || rows[i] == start[i]);
        }
      }
    }
  }
}

TEST(ScoreRowTest, AgreesWithTheReference) {
  const CoarseMaps coarse(1);
  for (const int64_t channels : {1, 4, 8, 13, 16}) {
    const int64_t width = CoarseMaps::kWidth;
    const int64_t plane_stride = width + 5;
    const Tensor<float> row = Random(width * ScoreStride(channels));
    Tensor<float> scratch(
        {ScoreScratchFloats(coarse.maps[0].width, coarse.maps[1].width, coarse.maps[2].width)});
    const auto run = [&](const OpenKernels& kernels, int64_t y) {
      Tensor<float> out = Filled(channels * plane_stride, kGuard);
      ScoreRow p = {.row = row.data(),
                    .width = width,
                    .channels = channels,
                    .out = out.data(),
                    .plane_stride = plane_stride,
                    .scratch = scratch.data()};
      for (int i = 0; i < 3; ++i) {
        p.maps[i] = coarse.maps[i];
        p.tap_y[i] = coarse.taps_y[i][static_cast<std::size_t>(y)];
        p.taps_x[i] = coarse.taps_x[i].data();
      }
      kernels.score_row(p);
      return out;
    };
    for (const int64_t y : {0, 1, 17, 31}) {
      const Tensor<float> expected = run(ReferenceOpenKernels(), y);
      for (const OpenKernels* const kernels : AllOpenSets()) {
        const Tensor<float> out = run(*kernels, y);
        for (int64_t i = 0; i < out.size(); ++i) {
          ASSERT_LE(std::abs(out[i] - expected[i]),
                    expected[i] == kGuard
                        ? 0.0
                        : SeluError(4.0) + 2.0 * (3.0 * 2.0 * Gamma(6) + Gamma(3) * 4.0))
              << IsaName(kernels->isa) << " " << channels << " " << i;
        }
      }
    }
  }
}

void CheckPlanarConv(int64_t in_channels, int64_t out_channels, int64_t height, int64_t width,
                     Activation activation) {
  SCOPED_TRACE(testing::Message() << in_channels << " to " << out_channels << ", " << width << " x "
                                  << height);
  const int64_t row_stride = width + 2 * kPlaneMargin;
  const int64_t plane_stride = (height + 2) * row_stride;
  Tensor<float> in(Shape{in_channels * plane_stride});
  const Tensor<float> values = Random(in.size());
  for (int64_t i = 0; i < in.size(); ++i) {
    const int64_t y = i % plane_stride / row_stride - 1;
    const int64_t x = i % row_stride - kPlaneMargin;
    in[i] = y >= 0 && y < height && x >= 0 && x < width ? values[i] : 0.0F;
  }
  const Tensor<float> weights = Random(out_channels * in_channels * 9);
  const auto run = [&](const OpenKernels& kernels) {
    Tensor<float> out = Filled(out_channels * plane_stride, kGuard);
    for (const auto& [begin, end] : {std::pair<int64_t, int64_t>{0, 1}, {1, height - 1}}) {
      kernels.planar_conv3x3({.in = in.data(),
                              .in_channels = in_channels,
                              .weights = weights.data(),
                              .activation = activation,
                              .out = out.data(),
                              .out_channels = out_channels,
                              .height = height,
                              .width = width,
                              .row_stride = row_stride,
                              .plane_stride = plane_stride,
                              .row_begin = begin,
                              .row_end = end});
    }
    return out;
  };
  const Tensor<float> expected = run(ReferenceOpenKernels());
  // Inputs and weights are at most 1; the slope of both activations at most kSeluScale kSeluAlpha.
  const auto n = static_cast<double>(9 * in_channels);
  const double bound =
      kSeluScale * kSeluAlpha * Gamma(9 * in_channels + 1) * n + SeluError(n) + 2.0 * Gamma(4);
  for (const OpenKernels* const kernels : AllOpenSets()) {
    const Tensor<float> out = run(*kernels);
    for (int64_t i = 0; i < out.size(); ++i) {
      ASSERT_LE(std::abs(out[i] - expected[i]), expected[i] == kGuard ? 0.0 : bound)
          << IsaName(kernels->isa) << " " << i;
    }
  }
}

TEST(PlanarConv3x3Test, AgreesWithTheReference) {
  for (const Activation activation : {Activation::kSelu, Activation::kSigmoid}) {
    for (const int64_t in_channels : {1, 4, 8}) {
      for (const int64_t out_channels : {1, 4, 5}) {
        CheckPlanarConv(in_channels, out_channels, 3, 16, activation);
        CheckPlanarConv(in_channels, out_channels, 5, 64, activation);
      }
    }
  }
}

// The reference itself: tap 5 is the right neighbour.
TEST(PlanarConv3x3Test, TapsAreRowByRow) {
  constexpr int64_t kWidth = 16;
  const int64_t row_stride = kWidth + 2 * kPlaneMargin;
  Tensor<float> in(Shape{3 * row_stride});
  in[row_stride + kPlaneMargin + 4] = 2.0F;
  Tensor<float> weights(Shape{9});
  weights[5] = 3.0F;
  Tensor<float> out(Shape{3 * row_stride});
  ReferenceOpenKernels().planar_conv3x3({.in = in.data(),
                                         .in_channels = 1,
                                         .weights = weights.data(),
                                         .out = out.data(),
                                         .out_channels = 1,
                                         .height = 1,
                                         .width = kWidth,
                                         .row_stride = row_stride,
                                         .plane_stride = 3 * row_stride,
                                         .row_begin = 0,
                                         .row_end = 1});
  EXPECT_FLOAT_EQ(out[row_stride + kPlaneMargin + 3], 6.0F * static_cast<float>(kSeluScale));
  EXPECT_FLOAT_EQ(out[row_stride + kPlaneMargin + 5], 0.0F);
}

}  // namespace
}  // namespace gluevo::nn::kernels
