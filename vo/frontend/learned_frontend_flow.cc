#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "gluevo/vo/core/stopwatch.h"
#include "gluevo/vo/frontend/learned_frontend.h"
#include "keypoint_pixel.h"

// What optical flow does for Method 2: keypoints below the pixel, a second opinion on matches, and
// tracks through frames on which no network runs.
namespace gluevo::vo {
namespace {

bool IsWithin(const cv::Point2f& a, const cv::Point2f& b, double distance) {
  const cv::Point2f difference = a - b;
  return difference.dot(difference) <= distance * distance;
}

// Moves the points that no match has carried here to where the edges of their neighbourhood meet
// (Foerstner and Guelch 1987), if that is near.
template <typename Tracks>
void BeginAtCorners(const cv::Mat& image, Tracks& tracks) {
  constexpr int kHalfWindow = 5;  // The window of what refines matches.
  constexpr double kFarthest = 4.0;
  std::vector<cv::Point2f> corners;
  std::vector<cv::Point2f*> points;
  for (auto& track : tracks) {
    if (track.tracking_confidence == 0.0F) {
      points.push_back(&track.left);
      corners.push_back(track.left);
    }
  }
  if (corners.empty()) {
    return;
  }
  const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 10, 0.02);
  cv::cornerSubPix(image, corners, {kHalfWindow, kHalfWindow}, {-1, -1}, until);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (IsWithin(corners[i], *points[i], kFarthest)) {
      *points[i] = corners[i];
    }
  }
}

}  // namespace

void LearnedFrontEnd::MakePyramids() {
  const bool follows = options_.network_every > 1 || options_.network_lag > 0;
  if (!options_.refine && !follows) {
    return;
  }
  Stopwatch watch;
  const int window = std::max(options_.refinement.window, options_.following.window);
  const int levels = follows ? std::max(options_.refinement.levels, options_.following.levels)
                             : options_.refinement.levels;
  for (int i = 0; i < 2; ++i) {
    now_.pyramids[i] = MakePyramid(now_.frame.images[i], window, levels);
  }
  now_.stages_ms["flow"] = watch.Lap();
}

bool LearnedFrontEnd::FollowTracks() {
  if (reference_ == nullptr || needs_networks_ || (options_.network_lag == 0 && NetworksAreDue())) {
    return false;
  }
  Stopwatch watch;
  std::vector<TrackedPoint> tracks;
  for (const auto& [id, track] : now_.previous_tracks) {
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
  const Flow flow = FollowFinely(
      now_.previous_pyramid, now_.pyramids[0], pixels,
      FollowBothWays(now_.previous_pyramid, now_.pyramids[0], pixels, guesses, options_.following),
      options_.refinement, options_.max_refinement_px);
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
  const double least_share =
      options_.network_lag > 0 ? std::min(options_.min_share_to_go_on, options_.min_followed_share)
                               : options_.min_followed_share;
  const auto fewest = least_share * static_cast<double>(tracks_to_keep_);
  if (static_cast<double>(followed.size()) < fewest) {
    now_.stages_ms["flow"] += watch.Lap();
    return false;
  }
  const Flow across =
      FollowBothWays(now_.pyramids[0], now_.pyramids[1], pixels, guesses, options_.refinement);
  for (std::size_t i = 0; i < stereo.size(); ++i) {
    TrackedPoint& track = followed[stereo[i]];
    if (across.found[i] != 0 && SeeTheSame(track.left, across.pixels[i])) {
      track.has_right = true;
      track.right = across.pixels[i];
    }
  }
  now_.tracks = std::move(followed);
  now_.stages_ms["flow"] += watch.Lap();
  return true;
}

void LearnedFrontEnd::RefineLeft(const KeypointView& from, const std::vector<Match>& carried,
                                 Sight& sight) const {
  struct Batch {
    const Pyramid* pyramid;
    std::vector<cv::Point2f> pixels, guesses;
    std::vector<int> keypoints;
  };
  // From the frame before where it has the track, else from where the networks saw it.
  Batch batches[] = {{&sight.previous_pyramid, {}, {}, {}}, {&from.pyramid, {}, {}, {}}};
  for (const Match& match : carried) {
    const TrackedPoint& old = from.tracks[match.from];
    const auto before = sight.previous_tracks.find(old.id);
    const bool is_there = before != sight.previous_tracks.end();
    Batch& batch = batches[is_there ? 0 : 1];
    batch.pixels.push_back(is_there ? before->second.left : old.left);
    batch.guesses.push_back(PixelOf(sight.view->features, match.to) +
                            (old.left - PixelOf(from.features, match.from)));
    batch.keypoints.push_back(match.to);
  }
  std::vector<int> refused;
  std::vector<cv::Point2f> refused_guesses;
  for (const Batch& batch : batches) {
    const Flow flow = FollowBothWays(*batch.pyramid, sight.pyramids[0], batch.pixels, batch.guesses,
                                     options_.refinement);
    for (std::size_t i = 0; i < batch.keypoints.size(); ++i) {
      TrackedPoint& track = sight.tracks[batch.keypoints[i]];
      if (flow.found[i] != 0 &&
          IsWithin(flow.pixels[i], batch.guesses[i], options_.max_refinement_px)) {
        track.left = flow.pixels[i];
      } else {
        refused.push_back(batch.keypoints[i]);
        refused_guesses.push_back(batch.guesses[i]);
      }
    }
  }
  if (FlowJudges(refused.size(), carried.size())) {
    for (const int keypoint : refused) {
      sight.tracks[keypoint] = {.left = sight.tracks[keypoint].left};
    }
    // Frames far apart have no use for it: there keypoints are what is seen again.
    if (options_.begin_at_corners && !carried.empty()) {
      BeginAtCorners(sight.frame.images[0], sight.tracks);
    }
  } else if (options_.begin_at_corners) {
    for (std::size_t i = 0; i < refused.size(); ++i) {
      sight.tracks[refused[i]].left = refused_guesses[i];
    }
  }
}

bool LearnedFrontEnd::FlowJudges(std::size_t refused, std::size_t matches) const {
  return static_cast<double>(matches - refused) >=
         options_.min_confirmed_share * static_cast<double>(matches);
}

void LearnedFrontEnd::AddRightViews(Sight& sight) const {
  Stopwatch watch;
  std::vector<cv::Point2f> pixels;
  std::vector<cv::Point2f> guesses;
  std::vector<int> keypoints;
  for (int i = 0; i < sight.view->features.size(); ++i) {
    const int match = sight.stereo.matches0[i];
    if (match < 0 ||
        !SeeTheSame(PixelOf(sight.view->features, i), PixelOf(sight.right_features, match))) {
      continue;
    }
    TrackedPoint& track = sight.tracks[i];
    track.has_right = true;
    track.stereo_confidence = sight.stereo.scores0[i];
    track.right = PixelOf(sight.right_features, match);
    if (options_.refine) {
      pixels.push_back(track.left);
      guesses.push_back(track.right + (track.left - PixelOf(sight.view->features, i)));
      keypoints.push_back(i);
    }
  }
  const Flow flow =
      FollowBothWays(sight.pyramids[0], sight.pyramids[1], pixels, guesses, options_.refinement);
  std::vector<int> refused;
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    TrackedPoint& track = sight.tracks[keypoints[i]];
    if (flow.found[i] != 0 && IsWithin(flow.pixels[i], guesses[i], options_.max_refinement_px) &&
        SeeTheSame(track.left, flow.pixels[i])) {
      track.right = flow.pixels[i];
    } else {
      refused.push_back(keypoints[i]);
    }
  }
  if (FlowJudges(refused.size(), keypoints.size())) {
    for (const int keypoint : refused) {
      sight.tracks[keypoint].has_right = false;
      sight.tracks[keypoint].stereo_confidence = 0.0F;
    }
  }
  sight.stages_ms["refine"] += watch.Lap();
}

}  // namespace gluevo::vo
