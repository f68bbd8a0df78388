#include "gluevo/vo/sliding_window.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "options_check.h"
#include "projection.h"

namespace gluevo::vo {
namespace {

/// What one view tells of a landmark: its error and how that changes with the inverse depth;
/// normalised plane.
struct ViewError {
  Eigen::Vector2d error;
  Eigen::Vector2d by_inverse_depth;
};

std::optional<ViewError> ErrorIn(const AnchoredPoint& point, const Rigid3& world_from_cam,
                                 const Eigen::Vector2d& observed) {
  const Eigen::Quaterniond cam_from_world = world_from_cam.rotation.conjugate();
  const Eigen::Vector3d offset = cam_from_world * (point.center - world_from_cam.translation);
  const Eigen::Vector3d in_cam = cam_from_world * point.ray + point.inverse_depth * offset;
  if (!IsInFront(in_cam)) {
    return std::nullopt;
  }
  return ViewError{in_cam.hnormalized() - observed, ProjectionJacobian(in_cam) * offset};
}

}  // namespace

void SlidingWindowOptions::Validate() const {
  CheckAtLeast(size, 3, "window.size");
  CheckPositive(noise, "window.noise");
  CheckPositive(huber, "window.huber");
  CheckAtLeast(max_iterations, 1, "window.max_iterations");
  CheckPositive(max_mean_error, "window.max_mean_error");
  CheckPositive(keyframe_parallax, "window.keyframe_parallax");
  CheckAtLeast(min_tracked, 0, "window.min_tracked");
  CheckAtLeast(min_long_tracked, 0, "window.min_long_tracked");
  CheckAtLeast(long_track, 2, "window.long_track");
  CheckPositive(max_new_share, "window.max_new_share");
  if (!(right_turn_sigma >= 0.0) || !std::isfinite(right_turn_sigma)) {
    throw Error("option window.right_turn_sigma is " + std::to_string(right_turn_sigma) +
                "; expected 0 or a positive number");
  }
  triangulation.Validate();
}

SlidingWindow::SlidingWindow(const StereoRig& rig, const SlidingWindowOptions& options)
    : rig_(rig), calibrated_body_from_right_(rig.body_from_cam[1].rotation), options_(options) {
  options_.Validate();
}

std::size_t SlidingWindow::CountLandmarks() const {
  return static_cast<std::size_t>(
      std::count_if(landmarks_.begin(), landmarks_.end(),
                    [](const auto& entry) { return entry.second.inverse_depth.has_value(); }));
}

std::size_t SlidingWindow::FrameIndex(int64_t frame_id) const {
  const auto found = std::lower_bound(frames_.begin(), frames_.end(), frame_id,
                                      [](const Frame& frame, int64_t id) { return frame.id < id; });
  return static_cast<std::size_t>(found - frames_.begin());
}

AnchoredPoint SlidingWindow::ToAnchoredPoint(const Landmark& landmark) const {
  const LandmarkView& anchor = landmark.views.front();
  const Rigid3 world_from_cam = FrameOf(anchor).world_from_body * rig_.body_from_cam[0];
  AnchoredPoint point{world_from_cam.translation,
                      world_from_cam.rotation * anchor.left.homogeneous(), *landmark.inverse_depth,
                      0.0};
  // The inverse depth's information, the poses taken as known.
  double information = 0.0;
  const auto add = [&](const Rigid3& world_from_body, int camera, const Eigen::Vector2d& seen) {
    const auto view = ErrorIn(point, world_from_body * rig_.body_from_cam[camera], seen);
    information += view ? view->by_inverse_depth.squaredNorm() : 0.0;
  };
  for (const LandmarkView& view : landmark.views) {
    const Rigid3& world_from_body = FrameOf(view).world_from_body;
    add(world_from_body, 0, view.left);
    if (view.right) {
      add(world_from_body, 1, *view.right);
    }
  }
  point.inverse_depth_sigma =
      information > 0.0 ? options_.noise / std::sqrt(information) : point.inverse_depth;
  return point;
}

std::vector<SlidingWindow::Correspondence> SlidingWindow::Correspond(
    const TrackedFrame& frame) const {
  std::vector<Correspondence> correspondences;
  for (std::size_t i = 0; i < frame.observations.size(); ++i) {
    const Observation& observation = frame.observations[i];
    const auto track = landmark_of_track_.find(observation.track_id);
    if (track == landmark_of_track_.end()) {
      continue;
    }
    const Landmark& landmark = landmarks_.at(track->second);
    if (landmark.inverse_depth) {
      correspondences.push_back({i,
                                 {ToAnchoredPoint(landmark), observation.left,
                                  observation.has_right, observation.right}});
    }
  }
  return correspondences;
}

void SlidingWindow::AddFrame(const TrackedFrame& frame, const Rigid3& world_from_body,
                             const std::vector<std::optional<PnpVerdict>>& verdicts) {
  frames_.push_back({next_frame_id_++, world_from_body});
  std::size_t new_tracks = 0;
  for (std::size_t i = 0; i < frame.observations.size(); ++i) {
    const Observation& observation = frame.observations[i];
    LandmarkView view{frames_.back().id, observation.left, std::nullopt};
    if (observation.has_right && verdicts[i] != PnpVerdict::kInlierLeft) {
      view.right = observation.right;
    }
    const auto track = landmark_of_track_.find(observation.track_id);
    if (track == landmark_of_track_.end() || verdicts[i] == PnpVerdict::kOutlier) {
      landmark_of_track_[observation.track_id] = next_landmark_id_;
      landmarks_[next_landmark_id_++] = {observation.track_id, {view}, std::nullopt};
      ++new_tracks;
    } else {
      landmarks_.at(track->second).views.push_back(view);
    }
  }
  DecideKeyframe(new_tracks);
}

void SlidingWindow::DecideKeyframe(std::size_t new_tracks) {
  Frame& newest = frames_.back();
  std::size_t tracked = 0;
  std::size_t long_tracked = 0;
  for (const auto& [id, landmark] : landmarks_) {
    if (landmark.views.size() > 1 && landmark.views.back().frame_id == newest.id) {
      ++tracked;
      long_tracked += landmark.views.size() >= static_cast<std::size_t>(options_.long_track);
    }
  }
  newest.lost_tracks = frames_.size() < 2 ||
                       tracked < static_cast<std::size_t>(options_.min_tracked) ||
                       long_tracked < static_cast<std::size_t>(options_.min_long_tracked) ||
                       static_cast<double>(new_tracks) > options_.max_new_share * tracked;
  newest.is_keyframe = newest.lost_tracks;
  if (!newest.is_keyframe) {
    const auto last_keyframe = std::find_if(std::next(frames_.rbegin()), frames_.rend(),
                                            [](const Frame& frame) { return frame.is_keyframe; });
    newest.is_keyframe = last_keyframe == frames_.rend() ||
                         MeanParallax(last_keyframe->id, newest.id) >= options_.keyframe_parallax;
  }
}

double SlidingWindow::MeanParallax(int64_t frame_id0, int64_t frame_id1) const {
  double sum = 0.0;
  int count = 0;
  for (const auto& [id, landmark] : landmarks_) {
    const auto see = [&](int64_t frame_id) {
      return std::find_if(landmark.views.begin(), landmark.views.end(),
                          [&](const LandmarkView& view) { return view.frame_id == frame_id; });
    };
    const auto view0 = see(frame_id0);
    const auto view1 = see(frame_id1);
    if (view0 != landmark.views.end() && view1 != landmark.views.end()) {
      sum += (view1->left - view0->left).norm();
      ++count;
    }
  }
  // Frames that share nothing are as far apart as can be.
  return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

void SlidingWindow::Triangulate() {
  for (auto& [id, landmark] : landmarks_) {
    if (landmark.inverse_depth) {
      continue;
    }
    std::vector<View> views;
    for (const LandmarkView& view : landmark.views) {
      const Rigid3& world_from_body = FrameOf(view).world_from_body;
      views.push_back({(world_from_body * rig_.body_from_cam[0]).Inverse(), view.left});
      if (view.right) {
        views.push_back({(world_from_body * rig_.body_from_cam[1]).Inverse(), *view.right});
      }
    }
    if (const auto point_in_world = vo::Triangulate(views, options_.triangulation)) {
      landmark.inverse_depth = 1.0 / (views.front().cam_from_world * *point_in_world).z();
    }
  }
}

std::optional<double> SlidingWindow::MeanReprojectionError(const Landmark& landmark) const {
  const AnchoredPoint point = ToAnchoredPoint(landmark);
  double sum = 0.0;
  int count = 0;
  for (const LandmarkView& view : landmark.views) {
    const Rigid3& world_from_body = FrameOf(view).world_from_body;
    for (int camera = 0; camera < 2; ++camera) {
      if (camera == 1 && !view.right) {
        continue;
      }
      const auto result = ErrorIn(point, world_from_body * rig_.body_from_cam[camera],
                                  camera == 0 ? view.left : *view.right);
      if (!result) {
        return std::nullopt;
      }
      // The anchor's left view has no error by definition: it does not count.
      if (camera == 1 || &view != &landmark.views.front()) {
        sum += result->error.norm();
        ++count;
      }
    }
  }
  return count > 0 ? sum / count : 0.0;
}

void SlidingWindow::RemoveOutliers() {
  for (auto it = landmarks_.begin(); it != landmarks_.end();) {
    const Landmark& landmark = it->second;
    if (!landmark.inverse_depth) {
      ++it;
      continue;
    }
    const bool in_front = *landmark.inverse_depth > 0.0;
    const auto error = in_front ? MeanReprojectionError(landmark) : std::nullopt;
    it = error && *error <= options_.max_mean_error ? std::next(it) : Erase(it);
  }
}

void SlidingWindow::Slide() {
  if (frames_.size() < static_cast<std::size_t>(options_.size)) {
    return;
  }
  const std::size_t newest_but_one = frames_.size() - 2;
  const bool keep = frames_[newest_but_one].is_keyframe || frames_.back().lost_tracks;
  DropFrame(keep ? 0 : newest_but_one);
}

void SlidingWindow::DropFrame(std::size_t index) {
  const int64_t frame_id = frames_[index].id;
  for (auto it = landmarks_.begin(); it != landmarks_.end();) {
    Landmark& landmark = it->second;
    const auto view = std::find_if(landmark.views.begin(), landmark.views.end(),
                                   [&](const LandmarkView& v) { return v.frame_id == frame_id; });
    if (view == landmark.views.end()) {
      ++it;
      continue;
    }
    const bool is_anchor = view == landmark.views.begin();
    std::optional<Eigen::Vector3d> point_in_world;
    if (is_anchor && landmark.inverse_depth) {
      point_in_world = ToAnchoredPoint(landmark).InWorld();
    }
    landmark.views.erase(view);
    if (landmark.views.empty()) {
      it = Erase(it);
      continue;
    }
    if (point_in_world) {
      const Rigid3 world_from_cam =
          FrameOf(landmark.views.front()).world_from_body * rig_.body_from_cam[0];
      const double depth = (world_from_cam.Inverse() * *point_in_world).z();
      if (!(depth > 0.0)) {
        it = Erase(it);
        continue;
      }
      landmark.inverse_depth = 1.0 / depth;
    }
    ++it;
  }
  frames_.erase(frames_.begin() + static_cast<std::ptrdiff_t>(index));
}

SlidingWindow::Landmarks::iterator SlidingWindow::Erase(Landmarks::iterator landmark) {
  const auto track = landmark_of_track_.find(landmark->second.track_id);
  if (track != landmark_of_track_.end() && track->second == landmark->first) {
    landmark_of_track_.erase(track);
  }
  return landmarks_.erase(landmark);
}

}  // namespace gluevo::vo
