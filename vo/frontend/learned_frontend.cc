#include "gluevo/vo/frontend/learned_frontend.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "gluevo/nn/option_error.h"
#include "gluevo/vo/core/options_check.h"

namespace gluevo::vo {
void LearnedFrontEndOptions::Validate() const {
  for (const auto& [name, threshold] :
       {std::pair{"tracking", tracking_threshold}, std::pair{"stereo", stereo_threshold}}) {
    if (!(threshold >= 0.0F && threshold < 1.0F)) {
      throw OptionError(std::string(name) + " threshold " + std::to_string(threshold) +
                        " is out of range: expected 0 or more and below 1 (--" + name +
                        "-threshold)");
    }
  }
  CheckPositive(max_epipolar_error_px, "max_epipolar_error_px (--max-epipolar-error)");
  CheckWithin(max_stereo_ratio, 0.0, 1.0, "max_stereo_ratio");
  CheckWithin(min_distance_px, 0.0, 1e6, "min_distance_px (--min-distance)");
  refinement.Validate("refinement");
  following.Validate("following");
  CheckPositive(max_refinement_px, "max_refinement_px");
  CheckWithin(min_confirmed_share, 0.0, 1.0, "min_confirmed_share (--min-confirmed-share)");
  CheckAtLeast(recovery_keyframes, 0, "recovery_keyframes (--recovery-keyframes)");
  CheckAtLeast(network_every, 1, "network_every (--superglue-every)");
  CheckWithin(min_followed_share, 0.0, 1.0, "min_followed_share");
  CheckWithin(min_share_to_go_on, 0.0, 1.0, "min_share_to_go_on");
  CheckAtLeast(network_lag, 0, "network_lag (--superglue-lag)");
}

LearnedFrontEnd::LearnedFrontEnd(const StereoRig& rig, std::unique_ptr<FeatureExtractor> extractor,
                                 std::unique_ptr<Matcher> matcher,
                                 std::unique_ptr<Matcher> fallback,
                                 const LearnedFrontEndOptions& options)
    : rig_(rig),
      epipolar_(rig),
      extractor_(std::move(extractor)),
      matcher_(std::move(matcher)),
      fallback_(std::move(fallback)),
      options_(options) {
  options_.Validate();
}

TrackedFrame LearnedFrontEnd::Track(const StereoFrame& frame) {
  CheckImages(frame, rig_);
  Advance();
  now_.frame = frame;
  MakePyramids();
  TakeInLate();
  bool is_followed = FollowTracks();
  if (!is_followed && late_) {
    AwaitLate();
    is_followed = FollowTracks();
  }
  if (!is_followed) {
    RunNetworks();
  } else if (NetworksAreDue() && !late_) {
    SendToNetworks();
  }
  return Observe();
}

std::optional<TrackedFrame> LearnedFrontEnd::Retry() {
  if (now_.view == nullptr) {
    const bool is_at_work_on_it = late_ && late_->age == 0;
    AwaitLate();
    if (!is_at_work_on_it) {
      RunNetworks();
    }
    return Observe();
  }
  if (!ways_) {
    FindWays();
  }
  if (ways_->empty()) {
    return std::nullopt;
  }
  const Way way = ways_->front();
  ways_->pop_front();
  MatchFrom(way, now_);
  StartTracks(now_);
  AddRightViews(now_);
  return Observe();
}

void LearnedFrontEnd::Accept(const FrameOutcome& outcome) { outcome_ = outcome; }

void LearnedFrontEnd::Advance() {
  if (outcome_.starts_segment) {
    keyframes_.clear();
  }
  if (late_ && (outcome_.starts_segment || (outcome_.is_passed_over && late_->age == 0))) {
    DiscardLate();
  }
  if (outcome_.is_passed_over) {
    needs_networks_ = true;
  } else {
    KeepFrame();
  }
  if (std::exchange(frames_are_missing_, false)) {
    needs_networks_ = true;
  }
  if (late_) {
    ++late_->age;
  }
  now_.view.reset();
  now_.tracks.clear();
  now_.stages_ms.clear();
  ways_.reset();
  outcome_ = {};
  networks_age_.reset();
}

void LearnedFrontEnd::KeepFrame() {
  now_.previous_tracks.clear();
  for (const TrackedPoint& track : now_.tracks) {
    now_.previous_tracks[track.id] = track;
  }
  now_.previous_pyramid = std::move(now_.pyramids[0]);
  ++frames_since_networks_;
  if (late_ && late_->age == 0) {
    late_->is_keyframe = outcome_.is_keyframe;
  }
  if (now_.view != nullptr) {
    tracks_to_keep_ = now_.tracks.size();
    now_.view->tracks = std::move(now_.tracks);
    now_.view->pyramid = now_.previous_pyramid;
    Remember(std::move(now_.view), outcome_.is_keyframe);
    frames_since_networks_ = 1;
    needs_networks_ = false;
  }
}

void LearnedFrontEnd::Remember(std::shared_ptr<const KeypointView> view, bool is_keyframe) {
  if (is_keyframe && options_.recovery_keyframes > 0) {
    keyframes_.push_front(view);
    keyframes_.resize(
        std::min(keyframes_.size(), static_cast<std::size_t>(options_.recovery_keyframes)));
  }
  reference_ = std::move(view);
}

void LearnedFrontEnd::RunNetworks() {
  RunNetworksOn(reference_, KeyframeToRematch(), now_);
  StartTracks(now_);
  networks_age_ = 0;
}

void LearnedFrontEnd::FindWays() {
  ways_.emplace();
  if (reference_ != nullptr && fallback_ != nullptr) {
    ways_->push_back({reference_, fallback_.get(), 0.0F});
  }
  for (const std::shared_ptr<const KeypointView>& keyframe : keyframes_) {
    if (keyframe == reference_) {
      continue;
    }
    ways_->push_back({keyframe, matcher_.get(), options_.tracking_threshold});
    if (fallback_ != nullptr) {
      ways_->push_back({keyframe, fallback_.get(), 0.0F});
    }
  }
}

bool LearnedFrontEnd::SeeTheSame(const cv::Point2f& left, const cv::Point2f& right) const {
  const Eigen::Vector2d in_left = rig_.cameras[0].Undistort(ToEigen(left));
  const Eigen::Vector2d in_right = rig_.cameras[1].Undistort(ToEigen(right));
  return epipolar_.Allows(in_left, in_right, options_.max_epipolar_error_px);
}

TrackedFrame LearnedFrontEnd::Observe() const {
  const std::vector<TrackedPoint>& tracks = now_.tracks;
  std::vector<int> order(tracks.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int i, int j) { return tracks[i].length > tracks[j].length; });

  TrackedFrame frame{now_.frame.timestamp_ns, {}, now_.stages_ms, networks_age_};
  const double min_squared_distance = options_.min_distance_px * options_.min_distance_px;
  for (const int i : order) {
    const TrackedPoint& track = tracks[i];
    Observation observation;
    observation.left_pixel = ToEigen(track.left);
    observation.left = rig_.cameras[0].Undistort(observation.left_pixel);
    const auto is_close = [&](const Observation& other) {
      return (other.left_pixel - observation.left_pixel).squaredNorm() < min_squared_distance;
    };
    if (!observation.left.allFinite() ||
        std::any_of(frame.observations.begin(), frame.observations.end(), is_close)) {
      continue;
    }
    observation.track_id = track.id;
    observation.tracking_confidence = track.tracking_confidence;
    if (track.has_right) {
      observation.has_right = true;
      observation.right_pixel = ToEigen(track.right);
      observation.right = rig_.cameras[1].Undistort(observation.right_pixel);
      observation.stereo_confidence = track.stereo_confidence;
    }
    frame.observations.push_back(observation);
  }
  return frame;
}

}  // namespace gluevo::vo
