#include "gluevo/vo/mapping/place_map_export.h"

#include <algorithm>
#include <cstdint>

namespace gluevo::vo {

Map SparseMapOf(const PlaceMap& map) {
  const std::vector<int> parts = map.Parts();
  Map sparse;
  sparse.cameras = map.rig.cameras;
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const Rigid3 map_from_left = map.map_from_body[i] * map.rig.body_from_cam[0];
    sparse.keyframes.push_back(
        {.timestamp_ns = map.keyframes[i].timestamp_ns,
         .segment = parts[i],
         .world_from_cam = {map_from_left, map.map_from_body[i] * map.rig.body_from_cam[1]}});
    for (const StereoKeypoint& keypoint : map.keyframes[i].keypoints) {
      if (keypoint.inverse_depth <= 0.0 || !keypoint.left.allFinite()) {
        continue;
      }
      const double near = std::clamp(keypoint.inverse_depth, 0.0, 1.0);
      constexpr double kDarkest = 55.0;
      constexpr double kBrighter = 200.0;
      sparse.points.push_back(
          {.point_in_world = map_from_left * (keypoint.left.homogeneous() / keypoint.inverse_depth),
           .segment = parts[i],
           .gray = static_cast<uint8_t>(kDarkest + kBrighter * near)});
    }
  }
  return sparse;
}

Trajectory KeyframesOf(const PlaceMap& map, int part) {
  const std::vector<int> parts = map.Parts();
  Trajectory poses;
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    if (parts[i] == part) {
      poses.push_back({map.keyframes[i].timestamp_ns, map.map_from_body[i]});
    }
  }
  std::stable_sort(poses.begin(), poses.end(),
                   [](const auto& a, const auto& b) { return a.timestamp_ns < b.timestamp_ns; });
  poses.erase(
      std::unique(poses.begin(), poses.end(),
                  [](const auto& a, const auto& b) { return a.timestamp_ns == b.timestamp_ns; }),
      poses.end());
  return poses;
}

}  // namespace gluevo::vo
