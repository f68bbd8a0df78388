#include <unordered_set>
#include <utility>
#include <vector>

#include "band_matching.h"
#include "gluevo/vo/core/stopwatch.h"
#include "gluevo/vo/frontend/learned_frontend.h"
#include "keypoint_pixel.h"

// What Method 2's networks make of one frame. Nothing here changes the front end, so that it may
// happen beside tracking.
namespace gluevo::vo {

void LearnedFrontEnd::RunNetworksOn(const std::shared_ptr<const KeypointView>& reference,
                                    const std::shared_ptr<const KeypointView>& keyframe,
                                    Sight& sight) const {
  Stopwatch watch;
  sight.view = std::make_shared<KeypointView>();
  sight.view->features = Extract(sight.frame.images[0], rig_.cameras[0]);
  sight.right_features = Extract(sight.frame.images[1], rig_.cameras[1]);
  sight.stages_ms[extractor_->Name()] = watch.Lap();
  MatchStereo(sight);
  sight.stages_ms["match_stereo"] = watch.Lap();
  MatchFrom({reference, matcher_.get(), options_.tracking_threshold}, sight);
  if (keyframe != nullptr) {
    RematchKeyframe(*keyframe, sight);
  }
  AddRightViews(sight);
}

void LearnedFrontEnd::MatchStereo(Sight& sight) const {
  const nn::Features& left = sight.view->features;
  const nn::Features& right = sight.right_features;
  if (!options_.stereo_in_band) {
    sight.stereo = matcher_->Match(left, right, options_.stereo_threshold);
    return;
  }
  sight.stereo =
      MatchInBand(left, RaysOf(left, rig_.cameras[0]), right, RaysOf(right, rig_.cameras[1]),
                  epipolar_, options_.max_epipolar_error_px, options_.max_stereo_ratio);
}

nn::Features LearnedFrontEnd::Extract(const cv::Mat& image, const Camera& camera) const {
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

void LearnedFrontEnd::MatchFrom(const Way& way, Sight& sight) const {
  Stopwatch watch;
  const int count = sight.view->features.size();
  sight.tracks.assign(static_cast<std::size_t>(count), {});
  for (int i = 0; i < count; ++i) {
    sight.tracks[i].left = PixelOf(sight.view->features, i);
  }
  if (way.from != nullptr) {
    const nn::Matches matches =
        way.matcher->Match(way.from->features, sight.view->features, way.threshold);
    sight.stages_ms["match_track"] += watch.Lap();
    CarryOn(*way.from, matches, sight);
    sight.stages_ms["refine"] += watch.Lap();
  }
}

void LearnedFrontEnd::StartTracks(Sight& sight) {
  for (TrackedPoint& track : sight.tracks) {
    track.id = track.id < 0 ? next_track_id_++ : track.id;
  }
}

void LearnedFrontEnd::CarryOn(const KeypointView& from, const nn::Matches& matches,
                              Sight& sight) const {
  std::unordered_set<int64_t> taken;
  for (const TrackedPoint& track : sight.tracks) {
    if (track.id >= 0) {
      taken.insert(track.id);
    }
  }
  const Tracks& previous = sight.previous_tracks;
  std::vector<Match> carried;
  for (std::size_t i = 0; i < matches.matches0.size(); ++i) {
    const int match = matches.matches0[i];
    if (match < 0 || sight.tracks[match].id >= 0 || !taken.insert(from.tracks[i].id).second) {
      continue;
    }
    const auto before = previous.find(from.tracks[i].id);
    const TrackedPoint& old = before != previous.end() ? before->second : from.tracks[i];
    TrackedPoint& track = sight.tracks[match];
    track.id = old.id;
    track.length = old.length + 1;
    track.tracking_confidence = matches.scores0[i];
    carried.push_back({static_cast<int>(i), match});
  }
  if (options_.refine) {
    RefineLeft(from, carried, sight);
  }
  for (const Match& match : carried) {
    const auto before = previous.find(from.tracks[match.from].id);
    if (before != previous.end()) {
      TrackedPoint& track = sight.tracks[match.to];
      track.motion = track.left - before->second.left;
    }
  }
}

std::shared_ptr<const LearnedFrontEnd::KeypointView> LearnedFrontEnd::KeyframeToRematch() const {
  const bool is_wanted =
      options_.rematch_keyframe && !keyframes_.empty() && keyframes_.front() != reference_;
  return is_wanted ? keyframes_.front() : nullptr;
}

void LearnedFrontEnd::RematchKeyframe(const KeypointView& keyframe, Sight& sight) const {
  Stopwatch watch;
  const nn::Matches matches =
      matcher_->Match(keyframe.features, sight.view->features, options_.tracking_threshold);
  sight.stages_ms["match_track"] += watch.Lap();
  CarryOn(keyframe, matches, sight);
  sight.stages_ms["refine"] += watch.Lap();
}

}  // namespace gluevo::vo
