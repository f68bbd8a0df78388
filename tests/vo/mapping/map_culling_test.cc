// Maps lose the key frames that others make needless, and nothing else.

#include "gluevo/vo/mapping/map_culling.h"

#include <gtest/gtest.h>

#include <numbers>

#include "gluevo/vo/core/seconds.h"
#include "message_of.h"
#include "vo/mapping/place_map_scene.h"

namespace gluevo::vo {
namespace {

constexpr int kRound = 24;

// Rounds through the room by an odometry that drifts, each but the first closed by one loop.
PlaceMap Rounds(int rounds) {
  PlaceMap map{.features = {"superpoint", "built-in", "12ab"}, .rig = testing::SimulatedRig()};
  for (int i = 0; i < rounds * kRound; ++i) {
    const double angle = 2.0 * std::numbers::pi / kRound * i;
    LoopKeyframe keyframe = testing::RoundKeyframe(angle, i);
    keyframe.segment = i / kRound;
    keyframe.world_from_body.translation.z() += 0.01 * i;
    if (i > 0) {
      keyframe.motion = map.keyframes.back().world_from_body.Inverse() * keyframe.world_from_body;
    }
    keyframe.motion_covariance.diagonal().setConstant(1e-4);
    map.keyframes.push_back(keyframe);
    map.map_from_body.push_back(testing::RoundPlace(angle));
  }
  for (std::size_t round = 1; round < static_cast<std::size_t>(rounds); ++round) {
    Loop loop{.candidate = 0, .query = round * kRound + 2, .measurement = {}, .inliers = 100};
    loop.measurement.candidate_from_query =
        map.map_from_body[0].Inverse() * map.map_from_body[loop.query];
    loop.measurement.covariance.diagonal().setConstant(1e-6);
    map.loops.push_back(loop);
  }
  return map;
}

TEST(MapCulling, GrowsWithSpaceAndNotWithTime) {
  const std::size_t one = CullPlaceMap(Rounds(1), {}).keyframes.size();
  const std::size_t three = CullPlaceMap(Rounds(3), {}).keyframes.size();
  const std::size_t six = CullPlaceMap(Rounds(6), {}).keyframes.size();
  EXPECT_GE(one, kRound * 9 / 10);
  EXPECT_LT(three, 3 * kRound);
  EXPECT_EQ(six, three);
}

TEST(MapCulling, WhatStaysIsAsItWas) {
  const PlaceMap map = Rounds(4);
  const PlaceMap culled = CullPlaceMap(map, {});
  ASSERT_LT(culled.keyframes.size(), map.keyframes.size());
  std::size_t from = 0;
  for (std::size_t i = 0; i < culled.keyframes.size(); ++i) {
    while (map.keyframes[from].timestamp_ns != culled.keyframes[i].timestamp_ns) {
      ++from;
    }
    EXPECT_EQ(culled.map_from_body[i].translation, map.map_from_body[from].translation);
    EXPECT_EQ(culled.keyframes[i].features.size(), map.keyframes[from].features.size());
  }
  EXPECT_EQ(CullPlaceMap(map, {.is_on = false}).keyframes.size(), map.keyframes.size());
}

TEST(MapCulling, PartsHangTogetherAndMotionsAddUp) {
  const PlaceMap culled = CullPlaceMap(Rounds(4), {});
  for (const int part : culled.Parts()) {
    EXPECT_EQ(part, 0);
  }
  ASSERT_FALSE(culled.loops.empty());
  for (const Loop& loop : culled.loops) {
    ASSERT_LT(loop.candidate, loop.query);
    ASSERT_LT(loop.query, culled.keyframes.size());
    const Rigid3 expected =
        culled.map_from_body[loop.candidate].Inverse() * culled.map_from_body[loop.query];
    EXPECT_LT((loop.measurement.candidate_from_query.translation - expected.translation).norm(),
              1e-9);
  }
  for (std::size_t i = 1; i < culled.keyframes.size(); ++i) {
    const LoopKeyframe& before = culled.keyframes[i - 1];
    const LoopKeyframe& now = culled.keyframes[i];
    EXPECT_TRUE(now.segment == before.segment || now.segment == before.segment + 1);
    const double steps = SecondsBetween(before.timestamp_ns, now.timestamp_ns);
    if (now.segment == before.segment) {
      EXPECT_GE(now.motion_covariance(0, 0), steps * 1e-4 * (1.0 - 1e-9));
    }
  }
}

TEST(MapCulling, PlacesOfOtherPartsDoNotCount) {
  PlaceMap map = Rounds(4);
  map.loops.clear();
  EXPECT_EQ(CullPlaceMap(map, {}).keyframes.size(),
            4 * CullPlaceMap(Rounds(1), {}).keyframes.size());
}

TEST(MapCulling, AnEmptyMapStaysEmpty) {
  EXPECT_TRUE(CullPlaceMap({.rig = testing::SimulatedRig()}, {}).keyframes.empty());
}

TEST(MapCulling, OptionsAreChecked) {
  EXPECT_NE(MessageOf([] { CullPlaceMap({}, {.min_views = 0}); }).find("culling.min_views"),
            std::string::npos);
}

}  // namespace
}  // namespace gluevo::vo
