#include "gluevo/vo/frontend/learned_frontend.h"

#include <algorithm>
#include <numeric>
#include <unordered_set>
#include <utility>

#include "gluevo/nn/option_error.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/stopwatch.h"
#include "keypoint_pixel.h"

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
  CheckWithin(min_distance_px, 0.0, 1e6, "min_distance_px (--min-distance)");
  refinement.Validate("refinement");
  following.Validate("following");
  CheckPositive(max_refinement_px, "max_refinement_px");
  CheckWithin(min_confirmed_share, 0.0, 1.0, "min_confirmed_share (--min-confirmed-share)");
  CheckAtLeast(recovery_keyframes, 0, "recovery_keyframes (--recovery-keyframes)");
  CheckAtLeast(network_every, 1, "network_every (--superglue-every)");
  CheckWithin(min_followed_share, 0.0, 1.0, "min_followed_share");
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
  frame_ = frame;
  MakePyramids();
  if (!FollowTracks()) {
    RunNetworks();
  }
  return Observe();
}

std::optional<TrackedFrame> LearnedFrontEnd::Retry() {
  if (view_ == nullptr) {
    RunNetworks();
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
  MatchFrom(way);
  StartTracks();
  AddRightViews();
  return Observe();
}

void LearnedFrontEnd::Accept(const FrameOutcome& outcome) { outcome_ = outcome; }

void LearnedFrontEnd::Advance() {
  if (outcome_.starts_segment) {
    keyframes_.clear();
  }
  if (outcome_.is_passed_over) {
    frames_since_networks_ = options_.network_every;
  } else {
    KeepFrame();
  }
  if (std::exchange(frames_are_missing_, false)) {
    frames_since_networks_ = options_.network_every;
  }
  view_.reset();
  tracks_.clear();
  ways_.reset();
  outcome_ = {};
  stages_ms_.clear();
}

void LearnedFrontEnd::KeepFrame() {
  previous_tracks_.clear();
  for (const TrackedPoint& track : tracks_) {
    previous_tracks_[track.id] = track;
  }
  previous_pyramid_ = std::move(pyramids_[0]);
  ++frames_since_networks_;
  if (view_ != nullptr) {
    view_->tracks = std::move(tracks_);
    view_->pyramid = previous_pyramid_;
    if (outcome_.is_keyframe && options_.recovery_keyframes > 0) {
      keyframes_.push_front(view_);
      keyframes_.resize(
          std::min(keyframes_.size(), static_cast<std::size_t>(options_.recovery_keyframes)));
    }
    reference_ = std::move(view_);
    frames_since_networks_ = 1;
  }
}

void LearnedFrontEnd::RunNetworks() {
  Stopwatch watch;
  view_ = std::make_shared<KeypointView>();
  view_->features = Extract(frame_.images[0], rig_.cameras[0]);
  right_features_ = Extract(frame_.images[1], rig_.cameras[1]);
  stages_ms_[extractor_->Name()] = watch.Lap();
  stereo_ = matcher_->Match(view_->features, right_features_, options_.stereo_threshold);
  stages_ms_["match_stereo"] = watch.Lap();
  MatchFrom({reference_, matcher_.get(), options_.tracking_threshold});
  if (options_.rematch_keyframe) {
    RematchKeyframe();
  }
  StartTracks();
  AddRightViews();
}

nn::Features LearnedFrontEnd::Extract(const cv::Mat& image, const Camera& camera) {
  nn::Features features = extractor_->Extract(image);
  // Pixels beyond the camera model have no ray: nothing can be made of what is seen there.
  std::vector<int> kept;
  for (int i = 0; i < features.size(); ++i) {
    if (camera.Undistort(ToEigen(PixelOf(features, i))).allFinite()) {
      kept.push_back(i);
    }
  }
  if (static_cast<int>(kept.size()) < features.size()) {
    features.keypoints = features.keypoints(kept, Eigen::all).eval();
    features.scores = features.scores(kept).eval();
    features.descriptors = features.descriptors(kept, Eigen::all).eval();
  }
  return features;
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

void LearnedFrontEnd::MatchFrom(const Way& way) {
  Stopwatch watch;
  const int count = view_->features.size();
  tracks_.assign(static_cast<std::size_t>(count), {});
  for (int i = 0; i < count; ++i) {
    tracks_[i].left = PixelOf(view_->features, i);
  }
  if (way.from != nullptr) {
    const nn::Matches matches =
        way.matcher->Match(way.from->features, view_->features, way.threshold);
    stages_ms_["match_track"] += watch.Lap();
    CarryOn(*way.from, matches);
    stages_ms_["refine"] += watch.Lap();
  }
}

void LearnedFrontEnd::StartTracks() {
  for (TrackedPoint& track : tracks_) {
    track.id = track.id < 0 ? next_track_id_++ : track.id;
  }
}

void LearnedFrontEnd::CarryOn(const KeypointView& from, const nn::Matches& matches) {
  std::unordered_set<int64_t> taken;
  for (const TrackedPoint& track : tracks_) {
    if (track.id >= 0) {
      taken.insert(track.id);
    }
  }
  std::vector<Match> carried;
  for (std::size_t i = 0; i < matches.matches0.size(); ++i) {
    const int match = matches.matches0[i];
    if (match < 0 || tracks_[match].id >= 0 || !taken.insert(from.tracks[i].id).second) {
      continue;
    }
    const auto before = previous_tracks_.find(from.tracks[i].id);
    const TrackedPoint& old = before != previous_tracks_.end() ? before->second : from.tracks[i];
    TrackedPoint& track = tracks_[match];
    track.id = old.id;
    track.length = old.length + 1;
    track.tracking_confidence = matches.scores0[i];
    carried.push_back({static_cast<int>(i), match});
  }
  if (options_.refine) {
    RefineLeft(from, carried);
  }
  for (const Match& match : carried) {
    const auto before = previous_tracks_.find(from.tracks[match.from].id);
    if (before != previous_tracks_.end()) {
      tracks_[match.to].motion = tracks_[match.to].left - before->second.left;
    }
  }
}

void LearnedFrontEnd::RematchKeyframe() {
  if (keyframes_.empty() || keyframes_.front() == reference_) {
    return;
  }
  Stopwatch watch;
  const KeypointView& keyframe = *keyframes_.front();
  const nn::Matches matches =
      matcher_->Match(keyframe.features, view_->features, options_.tracking_threshold);
  stages_ms_["match_track"] += watch.Lap();
  CarryOn(keyframe, matches);
  stages_ms_["refine"] += watch.Lap();
}

bool LearnedFrontEnd::SeeTheSame(const cv::Point2f& left, const cv::Point2f& right) const {
  const Eigen::Vector2d in_left = rig_.cameras[0].Undistort(ToEigen(left));
  const Eigen::Vector2d in_right = rig_.cameras[1].Undistort(ToEigen(right));
  return epipolar_.Allows(in_left, in_right, options_.max_epipolar_error_px);
}

TrackedFrame LearnedFrontEnd::Observe() const {
  std::vector<int> order(tracks_.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int i, int j) { return tracks_[i].length > tracks_[j].length; });

  TrackedFrame frame{frame_.timestamp_ns, {}, stages_ms_};
  const double min_squared_distance = options_.min_distance_px * options_.min_distance_px;
  for (const int i : order) {
    const TrackedPoint& track = tracks_[i];
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
