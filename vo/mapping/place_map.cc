#include "gluevo/vo/mapping/place_map.h"

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

bool IsSameCamera(const Camera& a, const Camera& b) {
  if (a.width != b.width || a.height != b.height) {
    return false;
  }
  // Half a pixel at the usual focal lengths.
  constexpr double kTolerance = 1e-3;
  constexpr double kShares[] = {0.1, 0.5, 0.9};
  for (const double x : kShares) {
    for (const double y : kShares) {
      const Eigen::Vector2d pixel(x * a.width, y * a.height);
      const Eigen::Vector2d in_a = a.Undistort(pixel);
      const Eigen::Vector2d in_b = b.Undistort(pixel);
      if (in_a.allFinite() != in_b.allFinite() ||
          (in_a.allFinite() && (in_a - in_b).norm() > kTolerance)) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

PlaceMap MakePlaceMap(const LoopCloser& closer, const std::vector<Rigid3>& map_from_body,
                      const MapFeatures& features) {
  PlaceMap map{.features = features,
               .rig = closer.rig(),
               .keyframes = closer.keyframes(),
               .loops = closer.loops(),
               .map_from_body = map_from_body};
  int number = -1;
  int last = -1;
  for (LoopKeyframe& keyframe : map.keyframes) {
    number += keyframe.segment != last ? 1 : 0;
    last = keyframe.segment;
    keyframe.segment = number;
  }
  return map;
}

bool IsSameRig(const StereoRig& a, const StereoRig& b) {
  constexpr double kMetres = 1e-3;
  constexpr double kRadians = 1e-3;
  for (std::size_t side = 0; side < 2; ++side) {
    const Rigid3 between = a.body_from_cam[side].Inverse() * b.body_from_cam[side];
    if (!IsSameCamera(a.cameras[side], b.cameras[side]) || between.translation.norm() > kMetres ||
        between.rotation.angularDistance(Eigen::Quaterniond::Identity()) > kRadians) {
      return false;
    }
  }
  return true;
}

void CheckMapFeatures(const PlaceMap& map, const std::string& map_name,
                      const MapFeatures& features) {
  if (map.features.network != features.network || map.features.checksum != features.checksum) {
    constexpr std::size_t kShown = 8;
    const auto name = [](const MapFeatures& of) {
      return of.network + " weights " + Quoted(of.source) + " (SHA-256 " +
             of.checksum.substr(0, kShown) + "...)";
    };
    throw Error(map_name + ": a map of the features of " + name(map.features) +
                " cannot be used with those of " + name(features) + "; expected the same weights");
  }
}

}  // namespace gluevo::vo
