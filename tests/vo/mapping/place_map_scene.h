#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/mapping/place_map.h"
#include "gluevo/vo/mapping/place_training.h"
#include "vo/mapping/loop_scene.h"

/// A map of a round through a simulated room.
namespace gluevo::vo::testing {

inline const std::vector<Eigen::Vector3d>& RoundRoom() {
  static const std::vector<Eigen::Vector3d> points = RoomPoints(1500, 4.0, 3);
  return points;
}

inline Rigid3 RoundPlace(double angle) {
  return {ExpSo3({0.0, 0.0, angle}), {1.5 * std::cos(angle), 1.5 * std::sin(angle), 0.1}};
}

inline LoopKeyframe RoundKeyframe(double angle, int64_t second) {
  constexpr int64_t kSecond = 1'000'000'000;
  return MakeLoopKeyframe(SimulatedRig(), RoundRoom(), RoundPlace(angle), RoundPlace(angle),
                          second * kSecond);
}

inline PlaceCodebook RoundCodebook() {
  return TrainPlaceCodebook({Look(SimulatedRig(), RoundRoom(), RoundPlace(0.0)).left,
                             Look(SimulatedRig(), RoundRoom(), RoundPlace(2.0)).left,
                             Look(SimulatedRig(), RoundRoom(), RoundPlace(4.0)).left},
                            "12ab", {.centres = 8});
}

inline LoopCloser RoundCloser() {
  return {SimulatedRig(), RoundCodebook(), MakeNearestNeighborMatcher(), {.min_age_s = 6.0}};
}

/// A round and a bit, twelve key frames a round, by an odometry that is right.
inline PlaceMap RoundMap() {
  LoopCloser closer = RoundCloser();
  constexpr int kKeyframes = 16;
  for (int i = 0; i < kKeyframes; ++i) {
    LoopKeyframe keyframe = RoundKeyframe(std::numbers::pi / 6.0 * i, i);
    if (i > 0) {
      keyframe.motion =
          closer.keyframes().back().world_from_body.Inverse() * keyframe.world_from_body;
    }
    keyframe.motion_covariance.diagonal() << 4e-4, 4e-4, 4e-4, 4e-5, 4e-5, 4e-5;
    closer.Add(std::move(keyframe));
  }
  return MakePlaceMap(closer, closer.Optimized(), {"superpoint", "built-in", "12ab"});
}

/// Two key frames of a few keypoints.
inline PlaceMap SmallMap() {
  PlaceMap map{.features = {"superpoint", "built-in", "12ab"}, .rig = SimulatedRig()};
  const std::vector<Eigen::Vector3d> points = RoomPoints(200, 4.0, 3);
  for (int i = 0; i < 2; ++i) {
    map.keyframes.push_back(MakeLoopKeyframe(SimulatedRig(), points, RoundPlace(0.1 * i),
                                             RoundPlace(0.1 * i), 1'000'000'000 * int64_t{i}));
    map.map_from_body.push_back(RoundPlace(0.1 * i));
  }
  return map;
}

}  // namespace gluevo::vo::testing
