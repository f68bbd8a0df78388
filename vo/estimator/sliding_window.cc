#include "gluevo/vo/estimator/sliding_window.h"

#include <algorithm>
#include <cmath>

#include "gluevo/nn/option_error.h"
#include "gluevo/vo/core/options_check.h"
#include "sliding_window_workspace.h"

namespace gluevo::vo {

void SlidingWindowOptions::Validate() const {
  CheckAtLeast(size, 3, "window.size (--window)");
  CheckPositive(noise_px, "window.noise_px");
  CheckPositive(huber, "window.huber");
  CheckAtLeast(max_iterations, 1, "window.max_iterations (--iterations)");
  CheckWithin(least_decrease, 0.0, 1.0, "window.least_decrease (--least-decrease)");
  if (solver != "gluevo" && solver != "ceres") {
    throw OptionError("option window.solver (--solver) is " + Quoted(solver) +
                      "; expected gluevo or ceres");
  }
  CheckPositive(max_mean_error_px, "window.max_mean_error_px");
  CheckPositive(keyframe_parallax_px, "window.keyframe_parallax_px (--keyframe-parallax)");
  CheckWithin(min_keyframe_overlap, 0.0, 1.0, "window.min_keyframe_overlap (--keyframe-overlap)");
  CheckAtLeast(min_tracked, 0, "window.min_tracked");
  CheckAtLeast(min_long_tracked, 0, "window.min_long_tracked");
  CheckAtLeast(long_track, 2, "window.long_track");
  CheckPositive(max_new_share, "window.max_new_share");
  CheckWithin(right_turn_sigma_mrad, 0.0, 1e6, "window.right_turn_sigma_mrad (--right-turn-mrad)");
  triangulation.Validate();
}

SlidingWindow::SlidingWindow(const StereoRig& rig, const SlidingWindowOptions& options,
                             const StereoCalibration& so_far)
    : calibrated_rig_(rig),
      calibration_(so_far),
      options_(options),
      workspace_(std::make_unique<Workspace>()) {
  options_.Validate();
}

SlidingWindow::~SlidingWindow() = default;
SlidingWindow::SlidingWindow(SlidingWindow&&) noexcept = default;
SlidingWindow& SlidingWindow::operator=(SlidingWindow&&) noexcept = default;

std::size_t SlidingWindow::CountLandmarks() const {
  return static_cast<std::size_t>(
      std::count_if(landmarks_.begin(), landmarks_.end(),
                    [](const auto& entry) { return entry.second.point.has_value(); }));
}

Trajectory SlidingWindow::Poses() const {
  Trajectory poses;
  poses.reserve(frames_.size());
  for (const Frame& frame : frames_) {
    poses.push_back({frame.timestamp_ns, frame.world_from_body});
  }
  return poses;
}

std::vector<MapPoint> SlidingWindow::MapPoints() const {
  std::vector<MapPoint> points;
  for (const auto& [id, landmark] : landmarks_) {
    if (landmark.point) {
      const Rigid3 world_from_anchor =
          FrameOf(landmark.views.front()).world_from_body * calibrated_rig_.body_from_cam[0];
      points.push_back(
          {landmark.track_id,
           world_from_anchor *
               Eigen::Vector3d(landmark.point->head<2>().homogeneous() / landmark.point->z())});
    }
  }
  return points;
}

std::size_t SlidingWindow::FrameIndex(int64_t frame_id) const {
  const auto found = std::lower_bound(frames_.begin(), frames_.end(), frame_id,
                                      [](const Frame& frame, int64_t id) { return frame.id < id; });
  return static_cast<std::size_t>(found - frames_.begin());
}

AnchoredPoint SlidingWindow::ToAnchoredPoint(const Landmark& landmark) const {
  const Rigid3 world_from_anchor =
      FrameOf(landmark.views.front()).world_from_body * calibrated_rig_.body_from_cam[0];
  return {world_from_anchor.translation,
          world_from_anchor.rotation * landmark.point->head<2>().homogeneous(),
          landmark.point->z()};
}

std::vector<SlidingWindow::Correspondence> SlidingWindow::Correspond(const TrackedFrame& frame,
                                                                     double noise) const {
  const StereoUndo undo(calibration_.correction);
  std::vector<Correspondence> correspondences;
  for (std::size_t i = 0; i < frame.observations.size(); ++i) {
    const Observation& observation = frame.observations[i];
    const auto track = landmark_of_track_.find(observation.track_id);
    if (track == landmark_of_track_.end()) {
      continue;
    }
    const Landmark& landmark = landmarks_.at(track->second);
    if (landmark.point) {
      AnchoredPoint point = ToAnchoredPoint(landmark);
      point.inverse_depth_sigma = InverseDepthSigma(landmark, noise);
      correspondences.push_back(
          {i,
           {point, observation.left, observation.has_right,
            observation.has_right ? undo(observation.right) : observation.right}});
    }
  }
  return correspondences;
}

void SlidingWindow::AddFrame(const TrackedFrame& frame, const Rigid3& world_from_body,
                             const std::vector<std::optional<PnpVerdict>>& verdicts) {
  frames_.push_back({next_frame_id_++, frame.timestamp_ns, world_from_body});
  if (readings_ != nullptr) {
    Measure(frames_[frames_.size() - 2], frames_.back());
  }
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
      Landmark& landmark = landmarks_.at(track->second);
      landmark.views.push_back(view);
      ++landmark.observations;
    }
  }
  DecideKeyframe(new_tracks);
}

void SlidingWindow::Slide() {
  if (frames_.size() < static_cast<std::size_t>(options_.size)) {
    return;
  }
  const std::size_t newest_but_one = frames_.size() - 2;
  if (!frames_[newest_but_one].is_keyframe && !frames_.back().lost_tracks) {
    if (prior_ && prior_->Find(frames_[newest_but_one].id)) {
      prior_ = WithoutFrame(*prior_, frames_[newest_but_one].id);
    }
    JoinAcross(newest_but_one);
    DropFrame(newest_but_one);
    return;
  }
  if (options_.marginalize || has_inertia()) {
    MarginalizeOldest();
  }
  DropFrame(0);
  frames_.front().measured.reset();
  frames_.front().still.reset();
}

SlidingWindow::Landmarks::iterator SlidingWindow::Erase(Landmarks::iterator landmark) {
  const auto track = landmark_of_track_.find(landmark->second.track_id);
  if (track != landmark_of_track_.end() && track->second == landmark->first) {
    landmark_of_track_.erase(track);
  }
  return landmarks_.erase(landmark);
}

}  // namespace gluevo::vo
