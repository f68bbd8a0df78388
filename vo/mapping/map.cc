#include "gluevo/vo/mapping/map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/geometry/projection.h"

namespace gluevo::vo {
namespace {

void CheckName(const std::string& name) {
  if (name.find_first_of(" \t\r\n") != std::string::npos) {
    throw Error("image '" + name +
                "': COLMAP's text files cannot hold names with blanks (--map), expected none");
  }
}

uint8_t GrayAt(const cv::Mat& image, const Eigen::Vector2d& pixel) {
  const auto nearest = [](double value, int size) {
    return std::clamp(static_cast<int>(std::lround(value)), 0, size - 1);
  };
  return image.at<uint8_t>(nearest(pixel.y(), image.rows), nearest(pixel.x(), image.cols));
}

}  // namespace

void CheckImageNames(const std::array<std::string, 2>& names) {
  for (const std::string& name : names) {
    CheckName(name);
  }
}

void TurnWorld(const Eigen::Quaterniond& new_from_old_world, Map& map) {
  const Rigid3 turn = {new_from_old_world, Eigen::Vector3d::Zero()};
  for (Map::Keyframe& keyframe : map.keyframes) {
    for (Rigid3& world_from_cam : keyframe.world_from_cam) {
      world_from_cam = turn * world_from_cam;
    }
  }
  for (Map::Point& point : map.points) {
    point.point_in_world = turn * point.point_in_world;
  }
}

void MapOptions::Validate() const {
  CheckPositive(max_reprojection_error_px, "map.max_reprojection_error_px");
  CheckAtLeast(min_views, 2, "map.min_views");
}

MapRecorder::MapRecorder(const std::array<Camera, 2>& cameras, const MapOptions& options)
    : cameras_(cameras), options_(options) {
  options_.Validate();
}

void MapRecorder::Add(const StereoFrame& frame, const std::array<std::string, 2>& image_names,
                      const FrameResult& result, const StereoRig& rig,
                      const std::vector<MapPoint>& window_points) {
  tracks_.resize(std::max(tracks_.size(), static_cast<std::size_t>(result.segment) + 1));
  if (result.is_keyframe) {
    AddKeyframe(frame, image_names, result, rig);
  }
  auto& tracks = tracks_[static_cast<std::size_t>(result.segment)];
  for (const MapPoint& point : window_points) {
    // Points that no key frame has seen are none of the map's.
    if (const auto track = tracks.find(point.track_id);
        track != tracks.end() && point.point_in_world.allFinite()) {
      track->second.point_in_world = point.point_in_world;
      track->second.has_point = true;
    }
  }
}

void MapRecorder::AddKeyframe(const StereoFrame& frame,
                              const std::array<std::string, 2>& image_names,
                              const FrameResult& result, const StereoRig& rig) {
  Keyframe keyframe;
  keyframe.frame.timestamp_ns = result.timestamp_ns;
  keyframe.frame.segment = result.segment;
  CheckImageNames(image_names);
  for (std::size_t side = 0; side < 2; ++side) {
    keyframe.frame.images[side] = image_names[side];
    keyframe.frame.world_from_cam[side] = result.world_from_body * rig.body_from_cam[side];
  }
  auto& tracks = tracks_[static_cast<std::size_t>(result.segment)];
  for (const Observation& observation : result.tracked_frame.observations) {
    keyframe.sightings.push_back({observation.track_id, observation.left_pixel.cast<float>(),
                                  observation.right_pixel.cast<float>(), observation.has_right});
    const auto [track, is_new] = tracks.try_emplace(observation.track_id);
    if (is_new) {
      track->second.gray = GrayAt(frame.images[0], observation.left_pixel);
    }
  }
  keyframes_.push_back(std::move(keyframe));
}

Map MapRecorder::Build() const {
  Map map;
  map.cameras = cameras_;
  struct Candidate {
    Map::View view;  // its point is still an index into candidates' points
    std::size_t keyframe = 0;
    std::size_t side = 0;
    double error_px = 0.0;
  };
  std::vector<std::unordered_map<int64_t, std::size_t>> point_of_track(tracks_.size());
  std::vector<Map::Point> points;
  std::vector<int> views_of;
  std::vector<Candidate> candidates;

  for (const Keyframe& keyframe : keyframes_) {
    const auto segment = static_cast<std::size_t>(keyframe.frame.segment);
    for (const Sighting& sighting : keyframe.sightings) {
      const Track& track = tracks_[segment].at(sighting.track_id);
      if (!track.has_point) {
        continue;
      }
      const auto [index, is_new] =
          point_of_track[segment].try_emplace(sighting.track_id, points.size());
      if (is_new) {
        points.push_back({track.point_in_world, keyframe.frame.segment, track.gray, 0.0});
        views_of.push_back(0);
      }
      for (std::size_t side = 0; side < (sighting.has_right ? 2 : 1); ++side) {
        const Eigen::Vector2d pixel =
            (side == 0 ? sighting.left_pixel : sighting.right_pixel).cast<double>();
        const Eigen::Vector3d in_cam =
            keyframe.frame.world_from_cam[side].Inverse() * track.point_in_world;
        if (!IsInFront(in_cam)) {
          continue;
        }
        const double error = (cameras_[side].Project(in_cam) - pixel).norm();
        if (error <= options_.max_reprojection_error_px) {
          candidates.push_back({{index->second, pixel}, map.keyframes.size(), side, error});
          points[index->second].mean_error_px += error;
          ++views_of[index->second];
        }
      }
    }
    map.keyframes.push_back(keyframe.frame);
  }

  constexpr auto kLeftOut = static_cast<std::size_t>(-1);
  std::vector<std::size_t> kept(points.size(), kLeftOut);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (views_of[i] >= options_.min_views) {
      kept[i] = map.points.size();
      map.points.push_back(points[i]);
      map.points.back().mean_error_px /= views_of[i];
    }
  }
  for (const Candidate& candidate : candidates) {
    if (kept[candidate.view.point] != kLeftOut) {
      map.keyframes[candidate.keyframe].views[candidate.side].push_back(
          {kept[candidate.view.point], candidate.view.pixel});
    }
  }
  return map;
}

}  // namespace gluevo::vo
