#include "gluevo/vo/mapping/global_adjustment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/geometry/manifold.h"
#include "vo/mapping/loop_scene.h"
#include "vo/mapping/place_map_scene.h"

namespace gluevo::vo {
namespace {

constexpr int kKeyframes = 14;

Rigid3 TruthAt(int i) { return testing::RoundPlace(std::numbers::pi / 18.0 * i); }

// A part of a round, whose odometry has motions off by a centimetre and some milliradians.
LoopCloser NoisyRound(std::vector<Rigid3>& by_odometry) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  LoopCloser closer = testing::RoundCloser();
  by_odometry = {TruthAt(0)};
  for (int i = 0; i < kKeyframes; ++i) {
    LoopKeyframe keyframe = testing::RoundKeyframe(std::numbers::pi / 18.0 * i, i);
    if (i > 0) {
      PoseTangent off;
      for (double& value : off) {
        value = normal(random);
      }
      off.head<3>() *= 0.01;
      off.tail<3>() *= 0.004;
      keyframe.motion = Plus(TruthAt(i - 1).Inverse() * TruthAt(i), off);
      by_odometry.push_back(by_odometry.back() * keyframe.motion);
    }
    keyframe.world_from_body = by_odometry.back();
    keyframe.motion_covariance.diagonal() << 1e-4, 1e-4, 1e-4, 1.6e-5, 1.6e-5, 1.6e-5;
    closer.Add(std::move(keyframe));
  }
  return closer;
}

double LargestError(const std::vector<Rigid3>& poses) {
  double largest = 0.0;
  for (int i = 0; i < kKeyframes; ++i) {
    largest = std::max(largest, (poses[i].translation - TruthAt(i).translation).norm());
  }
  return largest;
}

TEST(GlobalAdjustment, WhatAllKeyFramesSeeMakesThePathBetter) {
  std::vector<Rigid3> by_odometry;
  const LoopCloser closer = NoisyRound(by_odometry);
  GlobalAdjustmentOptions options;
  options.max_error_px = 40.0;
  const GlobalAdjustment adjusted =
      AdjustGlobally(closer, by_odometry, *MakeNearestNeighborMatcher(), options);
  EXPECT_TRUE(adjusted.is_kept);
  EXPECT_GT(adjusted.held_out, 20U);
  EXPECT_GT(adjusted.observations, adjusted.landmarks);
  EXPECT_LT(adjusted.error_after_px, 0.5 * adjusted.error_before_px);
  EXPECT_GT(LargestError(by_odometry), 0.03);
  EXPECT_LT(LargestError(adjusted.world_from_body), 0.5 * LargestError(by_odometry));
  EXPECT_EQ(adjusted.world_from_body[0].translation, by_odometry[0].translation);
  const GlobalAdjustment again =
      AdjustGlobally(closer, by_odometry, *MakeNearestNeighborMatcher(), options);
  EXPECT_EQ(again.world_from_body.back().translation, adjusted.world_from_body.back().translation);
}

TEST(GlobalAdjustment, WithoutViewsToJudgeByNothingIsKept) {
  std::vector<Rigid3> by_odometry;
  const LoopCloser closer = NoisyRound(by_odometry);
  GlobalAdjustmentOptions options;
  options.max_error_px = 1e-9;
  const GlobalAdjustment adjusted =
      AdjustGlobally(closer, by_odometry, *MakeNearestNeighborMatcher(), options);
  EXPECT_FALSE(adjusted.is_kept);
  EXPECT_EQ(adjusted.held_out, 0U);
  for (int i = 0; i < kKeyframes; ++i) {
    EXPECT_EQ(adjusted.world_from_body[i].translation, by_odometry[i].translation);
  }
}

}  // namespace
}  // namespace gluevo::vo
