#include "gluevo/vo/mapping/map_culling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/options_check.h"
#include "loop_measurement.h"

namespace gluevo::vo {
namespace {

/// Where the left camera of a key frame is, and its points, in the map's frame.
struct SeenPlace {
  Rigid3 map_from_cam;
  Rigid3 cam_from_map;
  std::vector<Eigen::Vector3d> points;
};

std::vector<SeenPlace> PlacesOf(const PlaceMap& map) {
  std::vector<SeenPlace> places;
  places.reserve(map.keyframes.size());
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const Rigid3 map_from_cam = map.map_from_body[i] * map.rig.body_from_cam[0];
    SeenPlace place{map_from_cam, map_from_cam.Inverse(), {}};
    for (const StereoKeypoint& keypoint : map.keyframes[i].keypoints) {
      if (keypoint.inverse_depth > 0.0) {
        place.points.emplace_back(place.map_from_cam *
                                  (keypoint.left.homogeneous() / keypoint.inverse_depth));
      }
    }
    places.push_back(std::move(place));
  }
  return places;
}

bool IsTurnedLike(const SeenPlace& a, const SeenPlace& b, double max_turn_deg) {
  return a.map_from_cam.rotation.angularDistance(b.map_from_cam.rotation) <= max_turn_deg * kDegree;
}

// Whether another camera sees a point of a place as the place does.
bool SeesAlike(const Camera& camera, const SeenPlace& place, const Eigen::Vector3d& point,
               const SeenPlace& other, const MapCullingOptions& options) {
  const Eigen::Vector3d in_other = other.cam_from_map * point;
  if (in_other.z() <= 0.0) {
    return false;
  }
  const Eigen::Vector2d pixel = camera.Project(in_other);
  if (!(pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() <= camera.width - 1.0 &&
        pixel.y() <= camera.height - 1.0)) {
    return false;
  }
  const Eigen::Vector3d here = point - place.map_from_cam.translation;
  const Eigen::Vector3d there = point - other.map_from_cam.translation;
  const double scale = there.norm() / here.norm();
  return std::max(scale, 1.0 / scale) <= options.max_scale &&
         here.normalized().dot(there.normalized()) >= std::cos(options.max_angle_deg * kDegree);
}

/// Decides which key frames stay.
class Culling {
 public:
  Culling(const PlaceMap& map, const MapCullingOptions& options)
      : camera_(map.rig.cameras[0]),
        options_(options),
        places_(PlacesOf(map)),
        parts_(map.Parts()),
        stays_(places_.size(), false) {
    // By those that are sure to stay: a chain of key frames each of which the next makes needless
    // must not go as a whole.
    for (std::size_t i = 0; i < places_.size(); ++i) {
      stays_[i] = !IsNeedless(i);
    }
  }

  bool Stays(std::size_t i) const { return stays_[i]; }

  /// The nearest that stays of those of the same part: there is one, which made it needless.
  std::size_t StandIn(std::size_t i) const {
    if (stays_[i]) {
      return i;
    }
    std::size_t nearest = i;
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < places_.size(); ++j) {
      const double to_j =
          (places_[j].map_from_cam.translation - places_[i].map_from_cam.translation).norm();
      if (stays_[j] && parts_[j] == parts_[i] && to_j < distance &&
          IsTurnedLike(places_[i], places_[j], options_.max_turn_deg)) {
        nearest = j;
        distance = to_j;
      }
    }
    return nearest;
  }

 private:
  bool IsNeedless(std::size_t i) const {
    std::vector<int> views(places_[i].points.size(), 0);
    for (std::size_t j = 0; j < i; ++j) {
      if (!stays_[j] || parts_[j] != parts_[i] ||
          !IsTurnedLike(places_[i], places_[j], options_.max_turn_deg)) {
        continue;
      }
      for (std::size_t k = 0; k < views.size(); ++k) {
        views[k] += SeesAlike(camera_, places_[i], places_[i].points[k], places_[j], options_);
      }
    }
    const auto seen = std::count_if(views.begin(), views.end(),
                                    [this](int count) { return count >= options_.min_views; });
    return !views.empty() &&
           static_cast<double>(seen) >= options_.min_share * static_cast<double>(views.size());
  }

  const Camera& camera_;
  const MapCullingOptions& options_;
  std::vector<SeenPlace> places_;
  std::vector<int> parts_;
  std::vector<bool> stays_;
};

// Where the map has b from a, exactly.
LoopMeasurement AsMapped(const PlaceMap& map, std::size_t a, std::size_t b) {
  return {map.map_from_body[a].Inverse() * map.map_from_body[b], PoseCovariance::Zero()};
}

std::vector<Loop> MovedLoops(const PlaceMap& map, const Culling& culling,
                             const std::vector<std::size_t>& number) {
  std::vector<Loop> loops;
  std::set<std::pair<std::size_t, std::size_t>> known;
  for (const Loop& loop : map.loops) {
    const std::size_t candidate = culling.StandIn(loop.candidate);
    const std::size_t query = culling.StandIn(loop.query);
    Loop moved = loop;
    moved.measurement = internal::Chained(
        internal::Chained(AsMapped(map, candidate, loop.candidate), loop.measurement),
        AsMapped(map, loop.query, query));
    moved.candidate = candidate;
    moved.query = query;
    if (query < candidate) {
      std::swap(moved.candidate, moved.query);
      moved.measurement = internal::Inverted(moved.measurement);
    }
    if (moved.candidate != moved.query && known.insert({moved.candidate, moved.query}).second) {
      moved.candidate = number[moved.candidate];
      moved.query = number[moved.query];
      loops.push_back(std::move(moved));
    }
  }
  return loops;
}

}  // namespace

void MapCullingOptions::Validate() const {
  CheckWithin(min_share, 0.0, 1.0, "culling.min_share");
  CheckAtLeast(min_views, 1, "culling.min_views");
  CheckWithin(max_angle_deg, 0.0, 90.0, "culling.max_angle_deg");
  CheckWithin(max_scale, 1.0, 100.0, "culling.max_scale");
  CheckWithin(max_turn_deg, 0.0, 180.0, "culling.max_turn_deg");
}

PlaceMap CullPlaceMap(PlaceMap map, const MapCullingOptions& options) {
  options.Validate();
  if (!options.is_on) {
    return map;
  }
  const Culling culling(map, options);
  PlaceMap culled{.features = map.features, .rig = map.rig};
  std::vector<std::size_t> number(map.keyframes.size(), 0);
  std::size_t last = map.keyframes.size();  // That stayed.
  int last_segment = 0;
  int segment = -1;
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    if (!culling.Stays(i)) {
      continue;
    }
    const bool starts_segment =
        culled.keyframes.empty() || last_segment != map.keyframes[i].segment;
    last_segment = map.keyframes[i].segment;
    segment += starts_segment ? 1 : 0;
    const LoopMeasurement motion =
        starts_segment ? LoopMeasurement() : OdometryBetween(map.keyframes, last, i);
    LoopKeyframe keyframe = std::move(map.keyframes[i]);  // Features are most of a map.
    keyframe.motion = motion.candidate_from_query;
    keyframe.motion_covariance = motion.covariance;
    keyframe.segment = segment;
    number[i] = culled.keyframes.size();
    culled.keyframes.push_back(std::move(keyframe));
    culled.map_from_body.push_back(map.map_from_body[i]);
    last = i;
  }
  culled.loops = MovedLoops(map, culling, number);
  return culled;
}

}  // namespace gluevo::vo
