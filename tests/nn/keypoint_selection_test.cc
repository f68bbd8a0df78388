#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "gluevo/nn/nearest_neighbor.h"
#include "gluevo/nn/superpoint.h"

namespace gluevo::nn {
namespace {

using Map = std::vector<float>;

// The published suppression, written out: max-pools over the whole map.
std::vector<int64_t> DenseSelection(const Map& scores, int64_t height, int64_t width,
                                    const SuperPointOptions& options) {
  const auto pool = [&](const Map& map) {
    Map out(map.size());
    for (int64_t y = 0; y < height; ++y) {
      for (int64_t x = 0; x < width; ++x) {
        float best = -1e9F;
        for (int64_t v = std::max<int64_t>(0, y - options.nms_radius);
             v <= std::min(height - 1, y + options.nms_radius); ++v) {
          for (int64_t u = std::max<int64_t>(0, x - options.nms_radius);
               u <= std::min(width - 1, x + options.nms_radius); ++u) {
            best = std::max(best, map[v * width + u]);
          }
        }
        out[y * width + x] = best;
      }
    }
    return out;
  };
  const Map first = pool(scores);
  Map mask(scores.size());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    mask[i] = scores[i] == first[i] ? 1.0F : 0.0F;
  }
  for (int round = 0; round < 2; ++round) {
    const Map near_mask = pool(mask);
    Map left = scores;
    for (std::size_t i = 0; i < scores.size(); ++i) {
      left[i] = near_mask[i] > 0.0F ? 0.0F : scores[i];
    }
    const Map best = pool(left);
    for (std::size_t i = 0; i < scores.size(); ++i) {
      if (left[i] == best[i] && near_mask[i] == 0.0F) {
        mask[i] = 1.0F;
      }
    }
  }
  std::vector<int64_t> keypoints;
  for (int64_t i = 0; i < height * width; ++i) {
    const int64_t y = i / width;
    const int64_t x = i % width;
    if (mask[i] > 0.0F && scores[i] > options.keypoint_threshold && y >= options.border &&
        x >= options.border && y < height - options.border && x < width - options.border) {
      keypoints.push_back(i);
    }
  }
  std::stable_sort(keypoints.begin(), keypoints.end(),
                   [&](int64_t i, int64_t j) { return scores[i] > scores[j]; });
  keypoints.resize(std::min<std::size_t>(keypoints.size(), options.max_keypoints));
  return keypoints;
}

TEST(SelectKeypointsTest, IsThePublishedSuppression) {
  std::mt19937 generator(3);
  ThreadPool pool(3);
  Workspace workspace(pool);
  for (int round = 0; round < 60; ++round) {
    const int64_t height = 8 + static_cast<int64_t>(generator() % 40);
    const int64_t width = 8 + static_cast<int64_t>(generator() % 40);
    // Few levels give many ties.
    const int levels = round % 3 == 0 ? 6 : 100000;
    Map scores(height * width);
    for (float& score : scores) {
      score = static_cast<float>(generator() % levels) / static_cast<float>(levels);
    }
    const SuperPointOptions options = {.keypoint_threshold = round % 2 == 0 ? 0.0F : 0.6F,
                                       .nms_radius = static_cast<int>(generator() % 6),
                                       .border = static_cast<int>(generator() % 5),
                                       .max_keypoints = round % 4 == 0 ? 7 : 100000};
    workspace.arena.Reset();
    std::vector<int64_t> keypoints;
    SelectKeypoints({scores.data(), {height, width}}, options, workspace, keypoints);
    EXPECT_EQ(keypoints, DenseSelection(scores, height, width, options)) << round;
  }
}

TEST(SampleDescriptorsTest, InterpolatesBetweenCells) {
  // Two cells along x with orthogonal descriptors. The published sampling puts the first cell's
  // centre at pixel 3.5 and the second's at 15 (of 16), so the middle is at 9.25.
  const std::vector<float> map = {1.0F, 0.0F, 0.0F, 1.0F, 1.0F, 0.0F, 0.0F, 1.0F};
  Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor> keypoints(3, 2);
  keypoints << 3.5F, 3.5F, 15.0F, 3.5F, 9.25F, 9.0F;
  Features::RowMajor descriptors;
  SampleDescriptors({map.data(), {2, 2, 2}}, keypoints, descriptors);
  EXPECT_LT((descriptors.row(0) - Eigen::RowVector2f(1.0F, 0.0F)).norm(), 1e-6F);
  EXPECT_LT((descriptors.row(1) - Eigen::RowVector2f(0.0F, 1.0F)).norm(), 1e-6F);
  EXPECT_LT((descriptors.row(2) - Eigen::RowVector2f::Constant(std::sqrt(0.5F))).norm(), 1e-6F);
}

Features WithDescriptors(const Features::RowMajor& descriptors) {
  Features features;
  features.keypoints.resize(descriptors.rows(), 2);
  features.descriptors = descriptors;
  return features;
}

TEST(NearestNeighborTest, KeepsMutualPairsAndAppliesItsBounds) {
  Features::RowMajor a(3, 2);
  a << 1.0F, 0.0F, 0.0F, 1.0F, 0.8F, 0.6F;
  Features::RowMajor b(2, 2);
  b << 0.0F, 1.0F, 1.0F, 0.0F;
  const Features features0 = WithDescriptors(a);
  const Features features1 = WithDescriptors(b);
  // The third point's nearest is b1, but b1's nearest is the first.
  EXPECT_EQ(MatchNearestNeighbors(features0, features1, {}).matches0, (std::vector<int>{1, 0, -1}));
  EXPECT_EQ(MatchNearestNeighbors(features0, features1, {.mutual = false}).matches0,
            (std::vector<int>{1, 0, 1}));
  EXPECT_EQ(MatchNearestNeighbors(features0, features1, {.mutual = false, .min_similarity = 0.9F})
                .matches0,
            (std::vector<int>{1, 0, -1}));
  // |a2 - b1|^2 = 0.4, |a2 - b0|^2 = 0.8: a ratio of 0.707.
  EXPECT_EQ(
      MatchNearestNeighbors(features0, features1, {.mutual = false, .max_ratio = 0.7F}).matches0[2],
      -1);
  EXPECT_EQ(MatchNearestNeighbors(features0, features1, {.mutual = false, .max_ratio = 0.72F})
                .matches0[2],
            1);
  EXPECT_THROW(MatchNearestNeighbors(features0, WithDescriptors(Features::RowMajor(1, 3)), {}),
               Error);
  EXPECT_TRUE(MatchNearestNeighbors(WithDescriptors(Features::RowMajor(0, 2)), features1, {})
                  .matches0.empty());
}

}  // namespace
}  // namespace gluevo::nn
