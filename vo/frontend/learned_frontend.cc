#include "gluevo/vo/frontend/learned_frontend.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_set>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/stopwatch.h"

namespace gluevo::vo {
namespace {

cv::Point2f PixelOf(const nn::Features& features, int keypoint) {
  return {features.keypoints(keypoint, 0), features.keypoints(keypoint, 1)};
}

Eigen::Vector2d ToEigen(const cv::Point2f& point) { return {point.x, point.y}; }

void CheckSize(const cv::Mat& image, const Camera& camera, const char* side) {
  if (image.cols != camera.width || image.rows != camera.height) {
    throw Error(std::string("the ") + side + " image has " + std::to_string(image.cols) + " x " +
                std::to_string(image.rows) + " pixels, its camera " + std::to_string(camera.width) +
                " x " + std::to_string(camera.height));
  }
}

bool IsWithin(const cv::Point2f& a, const cv::Point2f& b, double distance) {
  const cv::Point2f difference = a - b;
  return difference.dot(difference) <= distance * distance;
}

}  // namespace

void LearnedFrontEndOptions::Validate() const {
  for (const auto& [name, threshold] :
       {std::pair{"tracking", tracking_threshold}, std::pair{"stereo", stereo_threshold}}) {
    if (!(threshold >= 0.0F && threshold < 1.0F)) {
      throw Error(std::string(name) + " threshold " + std::to_string(threshold) +
                  " is out of range: expected 0 or more and below 1");
    }
  }
  if (!(max_epipolar_error_px > 0.0)) {
    throw Error("largest epipolar error " + std::to_string(max_epipolar_error_px) +
                " px is out of range: expected above 0");
  }
  if (!(min_distance_px >= 0.0)) {
    throw Error("minimum distance " + std::to_string(min_distance_px) +
                " px is out of range: expected 0 or more");
  }
  refinement.Validate("refinement");
  following.Validate("following");
  CheckPositive(max_refinement_px, "max_refinement_px");
  CheckWithin(min_confirmed_share, 0.0, 1.0, "min_confirmed_share");
  CheckAtLeast(recovery_keyframes, 0, "recovery_keyframes");
  CheckAtLeast(network_every, 1, "network_every");
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
  CheckSize(frame.images[0], rig_.cameras[0], "left");
  CheckSize(frame.images[1], rig_.cameras[1], "right");
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

void LearnedFrontEnd::Accept(bool is_keyframe) { is_keyframe_ = is_keyframe; }

void LearnedFrontEnd::Advance() {
  if (ways_ && ways_->empty()) {
    // The estimator has started again and knows none of the old tracks.
    keyframes_.clear();
  }
  previous_tracks_.clear();
  for (const TrackedPoint& track : tracks_) {
    previous_tracks_[track.id] = track;
  }
  previous_pyramid_ = std::move(pyramids_[0]);
  ++frames_since_networks_;
  if (view_ != nullptr) {
    view_->tracks = std::move(tracks_);
    view_->pyramid = previous_pyramid_;
    if (is_keyframe_ && options_.recovery_keyframes > 0) {
      keyframes_.push_front(view_);
      keyframes_.resize(
          std::min(keyframes_.size(), static_cast<std::size_t>(options_.recovery_keyframes)));
    }
    reference_ = std::move(view_);
    frames_since_networks_ = 1;
  } else if (is_keyframe_) {
    frames_since_networks_ = options_.network_every;
  }
  view_.reset();
  tracks_.clear();
  ways_.reset();
  is_keyframe_ = false;
  stages_ms_.clear();
}

void LearnedFrontEnd::MakePyramids() {
  const bool follows = options_.network_every > 1;
  if (!options_.refine && !follows) {
    return;
  }
  Stopwatch watch;
  const int window = std::max(options_.refinement.window, options_.following.window);
  const int levels = follows ? std::max(options_.refinement.levels, options_.following.levels)
                             : options_.refinement.levels;
  for (int i = 0; i < 2; ++i) {
    pyramids_[i] = MakePyramid(frame_.images[i], window, levels);
  }
  stages_ms_["flow"] = watch.Lap();
}

bool LearnedFrontEnd::FollowTracks() {
  if (reference_ == nullptr || frames_since_networks_ >= options_.network_every) {
    return false;
  }
  Stopwatch watch;
  std::vector<TrackedPoint> tracks;
  for (const auto& [id, track] : previous_tracks_) {
    tracks.push_back(track);
  }
  // In an order of their own, not the map's.
  std::sort(tracks.begin(), tracks.end(),
            [](const TrackedPoint& a, const TrackedPoint& b) { return a.id < b.id; });
  std::vector<cv::Point2f> pixels;
  std::vector<cv::Point2f> guesses;
  for (const TrackedPoint& track : tracks) {
    pixels.push_back(track.left);
    guesses.push_back(track.left + track.motion);
  }
  const Flow flow =
      FollowBothWays(previous_pyramid_, pyramids_[0], pixels, guesses, options_.following);
  std::vector<TrackedPoint> followed;
  pixels.clear();
  guesses.clear();
  std::vector<std::size_t> stereo;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (flow.found[i] == 0) {
      continue;
    }
    TrackedPoint track = tracks[i];
    ++track.length;
    track.motion = flow.pixels[i] - track.left;
    if (std::exchange(track.has_right, false)) {
      stereo.push_back(followed.size());
      pixels.push_back(flow.pixels[i]);
      guesses.push_back(flow.pixels[i] + (track.right - track.left));
    }
    track.left = flow.pixels[i];
    track.tracking_confidence = 1.0F;
    followed.push_back(track);
  }
  const auto fewest = options_.min_followed_share * static_cast<double>(reference_->tracks.size());
  if (static_cast<double>(followed.size()) < fewest) {
    stages_ms_["flow"] += watch.Lap();
    return false;
  }
  const Flow across =
      FollowBothWays(pyramids_[0], pyramids_[1], pixels, guesses, options_.refinement);
  for (std::size_t i = 0; i < stereo.size(); ++i) {
    TrackedPoint& track = followed[stereo[i]];
    if (across.found[i] != 0 && SeeTheSame(track.left, across.pixels[i])) {
      track.has_right = true;
      track.right = across.pixels[i];
    }
  }
  tracks_ = std::move(followed);
  stages_ms_["flow"] += watch.Lap();
  return true;
}

void LearnedFrontEnd::RunNetworks() {
  Stopwatch watch;
  view_ = std::make_shared<View>();
  view_->features = Extract(frame_.images[0], rig_.cameras[0]);
  right_features_ = Extract(frame_.images[1], rig_.cameras[1]);
  stages_ms_["superpoint"] = watch.Lap();
  stereo_ = matcher_->Match(view_->features, right_features_, options_.stereo_threshold);
  stages_ms_["superglue_stereo"] = watch.Lap();
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
  for (const std::shared_ptr<const View>& keyframe : keyframes_) {
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
    stages_ms_["superglue_track"] += watch.Lap();
    CarryOn(*way.from, matches);
    stages_ms_["refine"] += watch.Lap();
  }
}

void LearnedFrontEnd::StartTracks() {
  for (TrackedPoint& track : tracks_) {
    track.id = track.id < 0 ? next_track_id_++ : track.id;
  }
}

void LearnedFrontEnd::CarryOn(const View& from, const nn::Matches& matches) {
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

void LearnedFrontEnd::RefineLeft(const View& from, const std::vector<Match>& carried) {
  struct Batch {
    const Pyramid* pyramid;
    std::vector<cv::Point2f> pixels, guesses;
    std::vector<int> keypoints;
  };
  // From the frame before where it has the track, else from where the networks saw it.
  Batch batches[] = {{&previous_pyramid_, {}, {}, {}}, {&from.pyramid, {}, {}, {}}};
  for (const Match& match : carried) {
    const TrackedPoint& old = from.tracks[match.from];
    const auto before = previous_tracks_.find(old.id);
    const bool is_there = before != previous_tracks_.end();
    Batch& batch = batches[is_there ? 0 : 1];
    batch.pixels.push_back(is_there ? before->second.left : old.left);
    batch.guesses.push_back(tracks_[match.to].left +
                            (old.left - PixelOf(from.features, match.from)));
    batch.keypoints.push_back(match.to);
  }
  std::vector<int> refused;
  for (const Batch& batch : batches) {
    const Flow flow = FollowBothWays(*batch.pyramid, pyramids_[0], batch.pixels, batch.guesses,
                                     options_.refinement);
    for (std::size_t i = 0; i < batch.keypoints.size(); ++i) {
      TrackedPoint& track = tracks_[batch.keypoints[i]];
      if (flow.found[i] != 0 &&
          IsWithin(flow.pixels[i], batch.guesses[i], options_.max_refinement_px)) {
        track.left = flow.pixels[i];
      } else {
        refused.push_back(batch.keypoints[i]);
      }
    }
  }
  if (FlowJudges(refused.size(), carried.size())) {
    for (const int keypoint : refused) {
      tracks_[keypoint] = {.left = tracks_[keypoint].left};
    }
  }
}

bool LearnedFrontEnd::FlowJudges(std::size_t refused, std::size_t matches) const {
  return static_cast<double>(matches - refused) >=
         options_.min_confirmed_share * static_cast<double>(matches);
}

void LearnedFrontEnd::RematchKeyframe() {
  if (keyframes_.empty() || keyframes_.front() == reference_) {
    return;
  }
  Stopwatch watch;
  const View& keyframe = *keyframes_.front();
  const nn::Matches matches =
      matcher_->Match(keyframe.features, view_->features, options_.tracking_threshold);
  stages_ms_["superglue_track"] += watch.Lap();
  CarryOn(keyframe, matches);
  stages_ms_["refine"] += watch.Lap();
}

void LearnedFrontEnd::AddRightViews() {
  Stopwatch watch;
  std::vector<cv::Point2f> pixels;
  std::vector<cv::Point2f> guesses;
  std::vector<int> keypoints;
  for (int i = 0; i < view_->features.size(); ++i) {
    const int match = stereo_.matches0[i];
    if (match < 0 || !SeeTheSame(PixelOf(view_->features, i), PixelOf(right_features_, match))) {
      continue;
    }
    TrackedPoint& track = tracks_[i];
    track.has_right = true;
    track.stereo_confidence = stereo_.scores0[i];
    track.right = PixelOf(right_features_, match);
    if (options_.refine) {
      pixels.push_back(track.left);
      guesses.push_back(track.right + (track.left - PixelOf(view_->features, i)));
      keypoints.push_back(i);
    }
  }
  const Flow flow =
      FollowBothWays(pyramids_[0], pyramids_[1], pixels, guesses, options_.refinement);
  std::vector<int> refused;
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    TrackedPoint& track = tracks_[keypoints[i]];
    if (flow.found[i] != 0 && IsWithin(flow.pixels[i], guesses[i], options_.max_refinement_px) &&
        SeeTheSame(track.left, flow.pixels[i])) {
      track.right = flow.pixels[i];
    } else {
      refused.push_back(keypoints[i]);
    }
  }
  if (FlowJudges(refused.size(), keypoints.size())) {
    for (const int keypoint : refused) {
      tracks_[keypoint].has_right = false;
      tracks_[keypoint].stereo_confidence = 0.0F;
    }
  }
  stages_ms_["refine"] += watch.Lap();
}

bool LearnedFrontEnd::SeeTheSame(const cv::Point2f& left, const cv::Point2f& right) const {
  const Eigen::Vector2d in_left = rig_.cameras[0].Undistort(ToEigen(left));
  const Eigen::Vector2d in_right = rig_.cameras[1].Undistort(ToEigen(right));
  // Also false where a pixel is beyond the camera model and has no ray.
  return epipolar_.Distance(in_left, in_right) <= options_.max_epipolar_error_px &&
         epipolar_.InFront(in_left, in_right, options_.max_epipolar_error_px);
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
