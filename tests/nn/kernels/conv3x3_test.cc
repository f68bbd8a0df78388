#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "kernels/kernels.h"
#include "kernels/winograd.h"
#include "nn/kernels/kernel_test.h"

namespace gluevo::nn::kernels {
namespace {

struct ConvCase {
  int64_t in_channels, out_channels, height, width;
  bool relu, pool, affine;
};

// One convolution with random values, and what running it takes.
class ConvProblem {
 public:
  explicit ConvProblem(const ConvCase& c)
      : case_(c),
        gray_(c.in_channels == 1),
        in_(gray_ ? Random((c.height + 2) * (c.width + 2))
                  : Random(BlockedMap::Floats(BlocksOf(c.in_channels), c.height, c.width))),
        weights_(Random(c.out_channels * c.in_channels * 9)),
        bias_(Padded()),
        scale_(Padded()),
        shift_(Padded()) {
    if (gray_) {
      for (int64_t i = 0; i < in_.size(); ++i) {
        const int64_t y = i / (c.width + 2);
        const int64_t x = i % (c.width + 2);
        const bool halo = y == 0 || x == 0 || y == c.height + 1 || x == c.width + 1;
        in_[i] = halo ? 0.0F : in_[i];
      }
    } else {
      ClearHalo(in());
      // Padding channels are zero, as those of any convolution's output.
      for (int64_t y = -1; y <= c.height; ++y) {
        for (int64_t x = -1; x <= c.width; ++x) {
          for (int64_t i = c.in_channels; i < BlocksOf(c.in_channels) * kBlock; ++i) {
            in().pixel(i / kBlock, y, x)[i % kBlock] = 0.0F;
          }
        }
      }
    }
  }

  BlockedMap in() { return {in_.data(), BlocksOf(case_.in_channels), case_.height, case_.width}; }
  int64_t out_height() const { return case_.pool ? case_.height / 2 : case_.height; }
  int64_t out_width() const { return case_.pool ? case_.width / 2 : case_.width; }
  BlockedMap Map(Tensor<float>& out) const {
    return {out.data(), BlocksOf(case_.out_channels), out_height(), out_width()};
  }

  // In four regions, as threads do.
  Tensor<float> Run(void (*kernel)(const Conv3x3&), bool winograd) {
    Tensor<float> packed;
    if (winograd) {
      packed = Tensor<float>({PackedWinograd3x3Floats(case_.out_channels, case_.in_channels)});
      PackWinograd3x3(weights_.data(), case_.out_channels, case_.in_channels, packed.data());
    } else {
      packed = Tensor<float>({PackedConv3x3Floats(case_.out_channels, case_.in_channels)});
      PackConv3x3(weights_.data(), case_.out_channels, case_.in_channels, packed.data());
    }
    Tensor<float> scratch = Filled(WinogradScratchFloats(case_.in_channels), kGuard);
    Tensor<float> out =
        Filled(BlockedMap::Floats(BlocksOf(case_.out_channels), out_height(), out_width()), kGuard);
    const int64_t middle_row = case_.height / 2 / 4 * 4;
    const int64_t middle_column = case_.width / 2 / 4 * 4;
    for (const auto& [row_begin, row_end] :
         {std::pair<int64_t, int64_t>{0, middle_row}, {middle_row, case_.height}}) {
      for (const auto& [column_begin, column_end] :
           {std::pair<int64_t, int64_t>{0, middle_column}, {middle_column, case_.width}}) {
        kernel({.in = in(),
                .gray = gray_,
                .weights = packed.data(),
                .bias = bias_.data(),
                .relu = case_.relu,
                .scale = case_.affine ? scale_.data() : nullptr,
                .shift = case_.affine ? shift_.data() : nullptr,
                .pool = case_.pool,
                .out = Map(out),
                .row_begin = row_begin,
                .row_end = row_end,
                .column_begin = column_begin,
                .column_end = column_end,
                .scratch = scratch.data()});
      }
    }
    return out;
  }

  // Only these tiles, by Winograd; the other pixels stay kGuard.
  Tensor<float> RunTiles(const Kernels& kernels, const std::vector<int32_t>& tiles) {
    Tensor<float> packed({PackedWinograd3x3Floats(case_.out_channels, case_.in_channels)});
    PackWinograd3x3(weights_.data(), case_.out_channels, case_.in_channels, packed.data());
    Tensor<float> scratch = Filled(WinogradScratchFloats(case_.in_channels), kGuard);
    Tensor<float> out =
        Filled(BlockedMap::Floats(BlocksOf(case_.out_channels), out_height(), out_width()), kGuard);
    kernels.winograd3x3({.in = in(),
                         .weights = packed.data(),
                         .bias = bias_.data(),
                         .relu = case_.relu,
                         .out = Map(out),
                         .row_end = case_.height,
                         .column_end = case_.width,
                         .tiles = tiles.data(),
                         .tile_count = static_cast<int64_t>(tiles.size()),
                         .scratch = scratch.data()});
    return out;
  }

  // The definition, before pooling.
  double Exact(int64_t o, int64_t y, int64_t x) {
    double sum = bias_[o];
    for (int64_t i = 0; i < case_.in_channels; ++i) {
      for (int64_t tap = 0; tap < 9; ++tap) {
        sum += static_cast<double>(Weight(o, i, tap)) * Input(i, y + tap / 3 - 1, x + tap % 3 - 1);
      }
    }
    sum = case_.relu ? std::max(sum, 0.0) : sum;
    return case_.affine ? sum * scale_[o] + shift_[o] : sum;
  }

  double DirectBound(int64_t o, int64_t y, int64_t x) {
    double sum = std::abs(bias_[o]);
    for (int64_t i = 0; i < case_.in_channels; ++i) {
      for (int64_t tap = 0; tap < 9; ++tap) {
        sum += std::abs(static_cast<double>(Weight(o, i, tap)) *
                        Input(i, y + tap / 3 - 1, x + tap % 3 - 1));
      }
    }
    return Finish(o, sum, Gamma(9 * case_.in_channels + 3));
  }

  // |A^T| (sum over channels of |G g G^T| o (|B^T| |d| |B|)) |A|. Each of the two passes of both
  // transforms rounds a value at most 4 times and has up to 3 rounded constants as factors; a
  // weight is rounded once; the sums are over the channels.
  double WinogradBound(int64_t o, int64_t y, int64_t x) {
    constexpr double kA = 0.70710678118654752;
    constexpr std::array<double, 5> kPoints = {0.0, kA, -kA, 2 * kA, -2 * kA};
    constexpr double kInput[6][6] = {{1, 0, 2.5, 0, 1, 0},       {0, 2 * kA, 2, kA, 1, 0},
                                     {0, 2 * kA, 2, kA, 1, 0},   {0, kA, 0.5, 2 * kA, 1, 0},
                                     {0, kA, 0.5, 2 * kA, 1, 0}, {0, 1, 0, 2.5, 0, 1}};
    constexpr double kDivisors[6] = {1, -1.5, -1.5, 6, 6, 1};
    const auto kernel_row = [&](int64_t p, int64_t k) {
      return p == 5 ? (k == 2 ? 1.0 : 0.0) : std::pow(kPoints[p], k) / kDivisors[p];
    };
    const auto output_row = [&](int64_t i, int64_t p) {
      return p == 5 ? (i == 3 ? 1.0 : 0.0) : std::abs(std::pow(kPoints[p], i));
    };
    const int64_t top = y / 4 * 4 - 1;
    const int64_t left = x / 4 * 4 - 1;
    double sum = std::abs(bias_[o]);
    for (int64_t p = 0; p < 6; ++p) {
      for (int64_t q = 0; q < 6; ++q) {
        double products = 0.0;
        for (int64_t i = 0; i < case_.in_channels; ++i) {
          double input = 0.0;
          for (int64_t v = 0; v < 6; ++v) {
            for (int64_t u = 0; u < 6; ++u) {
              input += kInput[p][v] * kInput[q][u] * std::abs(Input(i, top + v, left + u));
            }
          }
          double kernel = 0.0;
          for (int64_t tap = 0; tap < 9; ++tap) {
            kernel += kernel_row(p, tap / 3) * kernel_row(q, tap % 3) * Weight(o, i, tap);
          }
          products += input * std::abs(kernel);
        }
        sum += output_row(y % 4, p) * output_row(x % 4, q) * products;
      }
    }
    return Finish(o, sum, Gamma(case_.in_channels + 4 * (4 + 3) + 1 + 3));
  }

 private:
  Tensor<float> Padded() const {
    Tensor<float> padded(Shape{BlocksOf(case_.out_channels) * kBlock});
    std::copy_n(Random(case_.out_channels).data(), case_.out_channels, padded.data());
    return padded;
  }
  float Weight(int64_t o, int64_t i, int64_t tap) const {
    return weights_[(o * case_.in_channels + i) * 9 + tap];
  }
  float Input(int64_t i, int64_t y, int64_t x) {
    if (y < 0 || x < 0 || y >= case_.height || x >= case_.width) {
      return 0.0F;
    }
    return gray_ ? in_[(y + 1) * (case_.width + 2) + x + 1]
                 : in().pixel(i / kBlock, y, x)[i % kBlock];
  }
  double Finish(int64_t o, double magnitude, double gamma) const {
    const double error = gamma * magnitude;
    return case_.affine ? std::abs(scale_[o]) * (error + 2 * kUnit * magnitude) +
                              2 * kUnit * std::abs(shift_[o])
                        : error;
  }

  ConvCase case_;
  bool gray_;
  Tensor<float> in_, weights_, bias_, scale_, shift_;
};

template <typename Bound>
void ExpectClose(ConvProblem& problem, const ConvCase& c, Tensor<float> out, const Bound& bound) {
  const BlockedMap map = problem.Map(out);
  const int64_t step = c.pool ? 2 : 1;
  for (int64_t block = 0; block < map.blocks; ++block) {
    for (int64_t y = -1; y <= map.height; ++y) {
      for (int64_t x = -1; x <= map.width; ++x) {
        if (y < 0 || x < 0 || y == map.height || x == map.width) {
          ASSERT_EQ(map.pixel(block, y, x)[0], kGuard) << "the halo is not the kernel's";
          continue;
        }
        for (int64_t i = 0; i < kBlock; ++i) {
          const int64_t o = block * kBlock + i;
          if (o >= c.out_channels) {
            ASSERT_EQ(map.pixel(block, y, x)[i], 0.0F) << "padding channel " << o;
            continue;
          }
          // The largest of values errs by no more than the one that errs most.
          double exact = -std::numeric_limits<double>::infinity();
          double error = 0.0;
          for (int64_t v = 0; v < step; ++v) {
            for (int64_t u = 0; u < step; ++u) {
              exact = std::max(exact, problem.Exact(o, y * step + v, x * step + u));
              error = std::max(error, bound(o, y * step + v, x * step + u));
            }
          }
          ASSERT_LE(std::abs(map.pixel(block, y, x)[i] - exact), error)
              << "channel " << o << " at " << x << ", " << y;
        }
      }
    }
  }
}

void Check(const ConvCase& c) {
  SCOPED_TRACE(testing::Message() << c.in_channels << "->" << c.out_channels << " at " << c.width
                                  << "x" << c.height << " relu " << c.relu << " pool " << c.pool
                                  << " affine " << c.affine);
  ConvProblem problem(c);
  const auto direct = [&](int64_t o, int64_t y, int64_t x) { return problem.DirectBound(o, y, x); };
  ExpectClose(problem, c, problem.Run(ReferenceKernels().conv3x3, false), direct);
  for (const Kernels* const kernels : AllSets()) {
    SCOPED_TRACE(IsaName(kernels->isa));
    ExpectClose(problem, c, problem.Run(kernels->conv3x3, false), direct);
    if (c.in_channels > 1) {
      SCOPED_TRACE("Winograd");
      ExpectClose(problem, c, problem.Run(kernels->winograd3x3, true),
                  [&](int64_t o, int64_t y, int64_t x) { return problem.WinogradBound(o, y, x); });
    }
  }
}

TEST(Conv3x3Test, AgreesWithTheDefinition) {
  for (const int64_t width : {2, 3, 4, 5, 7, 13, 14, 15, 31}) {
    for (const int64_t height : {2, 3, 5, 9}) {
      const bool pool = (width + height) % 2 == 0;
      const bool affine = width % 3 == 0;
      Check({1, 3, height, width, true, pool, affine});
      Check({5, 3, height, width, !pool, pool, affine});
    }
  }
  Check({1, 16, 1, 1, true, false, false});
  Check({2, 2, 1, 1, true, false, false});
}

TEST(Conv3x3Test, AgreesWithTheDefinitionOnManyChannels) {
  Check({16, 16, 5, 6, false, false, false});
  Check({20, 33, 4, 9, true, true, true});
  Check({48, 80, 2, 9, true, false, false});
  Check({128, 17, 3, 5, true, true, false});
}

TEST(Conv3x3Test, AgreesWithTheDefinitionAcrossSegmentsAndBlocksOfTiles) {
  for (const int64_t width : {57, 83, 85, 170}) {
    Check({1, 2, 2, width, true, false, false});
    Check({1, 2, 3, width, true, true, false});
    Check({2, 2, 17, width, true, width % 2 == 1, false});
  }
}

TEST(Conv3x3Test, SomeTilesAreThoseOfTheWholeAndTheOthersAreLeftAlone) {
  // 7 x 12 tiles, partial ones at the right and at the bottom; every third, some runs, the corners:
  // more than are computed at once.
  const ConvCase c = {20, 33, 26, 45, true, false, false};
  constexpr int64_t kTileColumns = 12;
  ConvProblem problem(c);
  std::vector<int32_t> tiles;
  std::vector<bool> chosen(7 * kTileColumns);
  for (int32_t tile = 0; tile < 7 * kTileColumns; ++tile) {
    chosen[tile] = tile % 3 == 0 || tile % 17 < 4 || tile == 7 * kTileColumns - 1;
    if (chosen[tile]) {
      tiles.push_back(tile);
    }
  }
  ASSERT_GT(tiles.size(), static_cast<std::size_t>(kWinogradTiles));
  for (const Kernels* const kernels : AllSets()) {
    SCOPED_TRACE(IsaName(kernels->isa));
    Tensor<float> whole = problem.Run(kernels->winograd3x3, true);
    Tensor<float> some = problem.RunTiles(*kernels, tiles);
    const BlockedMap whole_map = problem.Map(whole);
    const BlockedMap map = problem.Map(some);
    for (int64_t y = 0; y < c.height; ++y) {
      for (int64_t x = 0; x < c.width; ++x) {
        for (int64_t o = 0; o < c.out_channels; ++o) {
          const float value = map.pixel(o / kBlock, y, x)[o % kBlock];
          ASSERT_EQ(value, chosen[y / 4 * kTileColumns + x / 4]
                               ? whole_map.pixel(o / kBlock, y, x)[o % kBlock]
                               : kGuard)
              << "channel " << o << " at " << x << ", " << y;
        }
      }
    }
  }
}

TEST(Conv3x3Test, TheHaloCanBeComputedToo) {
  // The first layer writes the surroundings of a region of the second one's: begins are -1.
  const int64_t width = 17;
  const Tensor<float> plane = Random(11 * (width + 2));
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
                     .row_end = 5,
                     .column_begin = 0,
                     .column_end = width + 1});
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

}  // namespace
}  // namespace gluevo::nn::kernels
