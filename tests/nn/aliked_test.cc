#include "gluevo/nn/aliked.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "aliked_network.h"
#include "gluevo/nn/random_weights.h"
#include "nn/golden.h"
#include "nn/oracle_file.h"
#include "nn/plain_aliked.h"

namespace gluevo::nn {
namespace {

struct Image {
  std::vector<uint8_t> pixels;
  GrayImage view;
};

// Dark and bright rectangles.
Image RandomImage(int width, int height) {
  std::mt19937 random(5);
  Image image{std::vector<uint8_t>(static_cast<std::size_t>(width) * height, 100), {}};
  for (int i = 0; i < 40; ++i) {
    const int left = static_cast<int>(random() % static_cast<unsigned>(width));
    const int top = static_cast<int>(random() % static_cast<unsigned>(height));
    const auto value = static_cast<uint8_t>(random());
    for (int y = top; y < std::min(height, top + 9); ++y) {
      for (int x = left; x < std::min(width, left + 13); ++x) {
        image.pixels[static_cast<std::size_t>(y) * width + x] = value;
      }
    }
  }
  image.view = {image.pixels.data(), width, height, width};
  return image;
}

Features::RowMajor Matrix(const PlainMap& map) {
  Features::RowMajor matrix(map.height, map.width);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      matrix(y, x) = static_cast<float>(map.at(0, y, x));
    }
  }
  return matrix;
}

// A channel of a blocked map.
Features::RowMajor ChannelOf(const kernels::BlockedMap& map, int64_t channel) {
  Features::RowMajor matrix(map.height, map.width);
  for (int64_t y = 0; y < map.height; ++y) {
    for (int64_t x = 0; x < map.width; ++x) {
      matrix(y, x) = map.pixel(channel / kernels::kBlock, y, x)[channel % kernels::kBlock];
    }
  }
  return matrix;
}

// The deformable layers take differences of positions in floats, of up to 24 pixels here: a part in
// 2^19 of a pixel, between values that differ by as much as their size.
constexpr double kTolerance = 4.0 * kNetworkTolerance;

class AlikedIsas : public testing::TestWithParam<Isa> {};

INSTANTIATE_TEST_SUITE_P(Isas, AlikedIsas, testing::ValuesIn(SupportedIsas()),
                         [](const auto& test) { return IsaName(test.param); });

struct Sizes {
  std::array<int64_t, 4> widths;
  int64_t size, samples;
  int width, height;
};

// n16, t16 and n32, and odd ones; images that are padded on some sides or on none.
TEST_P(AlikedIsas, MapsAndDescriptorsAreThoseOfThePlainNetwork) {
  for (const Sizes& sizes : {Sizes{{16, 32, 64, 128}, 128, 16, 64, 32},
                             {{8, 16, 32, 64}, 64, 16, 53, 39},
                             {{16, 32, 64, 128}, 128, 32, 40, 33},
                             {{5, 20, 17, 36}, 64, 3, 70, 29}}) {
    SCOPED_TRACE(testing::Message()
                 << sizes.widths[0] << " channels, " << sizes.width << " x " << sizes.height);
    const Weights weights = RandomAlikedWeights(sizes.widths, sizes.size, sizes.samples);
    const Image image = RandomImage(sizes.width, sizes.height);
    const PlainAliked plain(weights, image.view);
    const AlikedNetwork network(ReadAlikedWeights(weights), GetParam());
    ThreadPool pool(2);
    Workspace workspace(pool);
    const AlikedMaps maps = network.Encode(image.view, true, workspace);
    for (std::size_t i = 0; i < 4; ++i) {
      for (const int c : {0, static_cast<int>(sizes.widths[i]) - 1}) {
        const PlainMap& block = plain.blocks[i];
        PlainMap channel(1, block.height, block.width);
        std::copy_n(block.values.begin() + static_cast<std::ptrdiff_t>(c * channel.values.size()),
                    channel.values.size(), channel.values.begin());
        EXPECT_LT(RelativeRms(ChannelOf(maps.blocks[i], c), Matrix(channel)), kTolerance)
            << "block " << i + 1 << " channel " << c;
      }
    }
    const TensorView<float> scores = network.Scores(maps, workspace);
    EXPECT_LT(RelativeRms(scores.Matrix(), Matrix(plain.scores)), kTolerance);

    Features features;
    features.keypoints.resize(31, 2);
    for (int i = 0; i < 31; ++i) {
      features.keypoints(i, 0) = static_cast<float>(i * 7 % sizes.width) + 0.3F;
      features.keypoints(i, 1) = static_cast<float>(i * 5 % sizes.height) + 0.6F;
    }
    const Aliked aliked(weights, GetParam());
    aliked.Describe(image.view, workspace, features);
    ASSERT_EQ(features.descriptors.cols(), sizes.size);
    for (int i = 0; i < 31; ++i) {
      const std::vector<double> expected =
          plain.Describe(features.keypoints(i, 0), features.keypoints(i, 1));
      for (std::size_t c = 0; c < expected.size(); ++c) {
        ASSERT_NEAR(features.descriptors(i, static_cast<Eigen::Index>(c)), expected[c], kTolerance)
            << i << " " << c;
      }
    }
  }
}

TEST(AlikedTest, KeypointsArePeaksRefinedByTheirNeighbours) {
  const Weights weights = RandomAlikedWeights();
  const Image image = RandomImage(90, 70);
  const Aliked aliked(weights);
  ThreadPool pool(2);
  Workspace workspace(pool);
  const Features::RowMajor scores = aliked.Scores(image.view, workspace).Matrix();
  // A tenth of the pixels pass it.
  std::vector<float> sorted(scores.data(), scores.data() + scores.size());
  std::sort(sorted.begin(), sorted.end());
  const float threshold = sorted[sorted.size() / 10 * 9];
  Features features;
  aliked.Extract(image.view, {.keypoint_threshold = threshold}, workspace, features);
  ASSERT_GT(features.size(), 3);
  EXPECT_EQ(features.width, 90);
  for (int i = 0; i < features.size(); ++i) {
    const auto x = static_cast<Eigen::Index>(std::lround(features.keypoints(i, 0)));
    const auto y = static_cast<Eigen::Index>(std::lround(features.keypoints(i, 1)));
    EXPECT_GE(x, 0);
    EXPECT_LT(x, 90);
    // A peak above the threshold is within the radius.
    const Eigen::Index left = std::max<Eigen::Index>(x - 2, 0);
    const Eigen::Index top = std::max<Eigen::Index>(y - 2, 0);
    EXPECT_GT(scores
                  .block(top, left, std::min<Eigen::Index>(5, 70 - top),
                         std::min<Eigen::Index>(5, 90 - left))
                  .maxCoeff(),
              threshold);
    EXPECT_GT(features.scores[i], 0.0F);
    EXPECT_NEAR(features.descriptors.row(i).norm(), 1.0F, 1e-5F);
  }
  Features best;
  aliked.Extract(image.view, {.keypoint_threshold = threshold, .max_keypoints = 3}, workspace,
                 best);
  ASSERT_EQ(best.size(), 3);
  EXPECT_EQ(best.keypoints, features.keypoints.topRows(3));
}

TEST(AlikedTest, IsTheSameForAnyNumberOfThreads) {
  const Aliked aliked(RandomAlikedWeights());
  const Image image = RandomImage(150, 83);
  std::vector<Features> results;
  for (const int threads : {1, 2, 3, 5}) {
    ThreadPool pool(threads);
    Workspace workspace(pool);
    aliked.Extract(image.view, {.keypoint_threshold = 0.0F, .max_keypoints = 100}, workspace,
                   results.emplace_back());
    EXPECT_EQ(results.back().keypoints, results[0].keypoints);
    EXPECT_EQ(results.back().scores, results[0].scores);
    EXPECT_EQ(results.back().descriptors, results[0].descriptors);
  }
  EXPECT_GT(results[0].size(), 20);
}

// Padded to one cell of the coarsest map.
TEST(AlikedTest, TakesTheSmallestImages) {
  const Aliked aliked(RandomAlikedWeights());
  ThreadPool pool(1);
  Workspace workspace(pool);
  Features features;
  aliked.Extract(RandomImage(8, 8).view, {.keypoint_threshold = 0.0F}, workspace, features);
  EXPECT_TRUE(features.descriptors.allFinite());
  EXPECT_THROW(aliked.Extract(RandomImage(7, 8).view, {}, workspace, features), Error);
}

template <typename Call>
void ExpectError(const Call& call, const std::string& text) {
  try {
    call();
    FAIL() << text;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
  }
}

TEST(AlikedTest, RefusesWhatIsNoAliked) {
  ExpectError([] { Aliked{OpenSuperPointWeights()}; }, "these are a SuperPoint's");
  Weights weights = RandomAlikedWeights();
  weights.tensors["block3.conv1.offset_conv.weight"] = Tensor<float>(Shape{17, 32, 3, 3});
  ExpectError([&] { Aliked{weights}; },
              "\"block3.conv1.offset_conv.weight\" has shape [17 x 32 x 3 x 3]");
  weights = RandomAlikedWeights();
  weights.tensors["block1.bn1.running_var"][3] = -1.0F;
  ExpectError([&] { Aliked{weights}; }, "block1.bn1.running_var");
  weights = RandomAlikedWeights();
  weights.tensors.erase("score_head.4.weight");
  ExpectError([&] { Aliked{weights}; }, "score_head.4.weight");
  ExpectError([] { AlikedOptions{.keypoint_threshold = 1.0F}.Validate(); }, "keypoint threshold");
}

}  // namespace
}  // namespace gluevo::nn
