#include <algorithm>
#include <chrono>
#include <utility>

#include "gluevo/vo/core/stopwatch.h"
#include "gluevo/vo/frontend/learned_frontend.h"

// Networks beside tracking: a frame is sent to them, optical flow goes on, and what they made of it
// is carried on from there to where tracking is by then.
namespace gluevo::vo {

bool LearnedFrontEnd::NetworksAreDue() const {
  const auto fewest = options_.min_followed_share * static_cast<double>(tracks_to_keep_);
  const bool tracks_are_few =
      options_.network_lag > 0 && static_cast<double>(now_.tracks.size()) < fewest;
  return tracks_are_few || frames_since_networks_ >= options_.network_every;
}

void LearnedFrontEnd::SendToNetworks() {
  Sight sight{now_.frame, now_.pyramids, now_.previous_tracks, now_.previous_pyramid};
  for (cv::Mat& image : sight.frame.images) {
    image = image.clone();  // The caller may use its memory again.
  }
  late_ = LateSight{.sight = std::async(std::launch::async,
                                        [this, sight = std::move(sight), reference = reference_,
                                         keyframe = KeyframeToRematch()]() mutable {
                                          RunNetworksOn(reference, keyframe, sight);
                                          return std::move(sight);
                                        })};
  frames_since_networks_ = 0;
}

void LearnedFrontEnd::TakeInLate() {
  if (!late_ || late_->age < options_.network_lag) {
    return;
  }
  if (options_.awaits_networks ||
      late_->sight.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    AwaitLate();
  }
}

void LearnedFrontEnd::AwaitLate() {
  if (!late_) {
    return;
  }
  LateSight late = *std::exchange(late_, std::nullopt);
  Stopwatch watch;
  Sight sight = late.sight.get();
  now_.stages_ms["networks_wait"] += watch.Lap();
  StartTracks(sight);
  for (const auto& [stage, ms] : sight.stages_ms) {
    now_.stages_ms[stage] += ms;
  }
  networks_age_ = late.age;
  if (late.age == 0) {
    sight.stages_ms = std::move(now_.stages_ms);
    now_ = std::move(sight);
  } else {
    CarryToNow(std::move(sight), late.is_keyframe);
  }
}

void LearnedFrontEnd::DiscardLate() {
  late_.reset();
  frames_since_networks_ = options_.network_every;
}

void LearnedFrontEnd::CarryToNow(Sight late, bool is_keyframe) {
  Stopwatch watch;
  Tracks carried;
  std::vector<TrackedPoint> unknown;
  for (const TrackedPoint& track : late.tracks) {
    const auto followed = now_.previous_tracks.find(track.id);
    if (followed == now_.previous_tracks.end()) {
      unknown.push_back(track);
      continue;
    }
    TrackedPoint& point = carried[track.id] = followed->second;
    if (track.has_right && !point.has_right) {
      // Flow begins its search there.
      point.has_right = true;
      point.right = point.left + (track.right - track.left);
    }
  }
  for (const TrackedPoint& point : FollowToBefore(late, unknown)) {
    carried[point.id] = point;
  }
  now_.previous_tracks = std::move(carried);
  tracks_to_keep_ = now_.previous_tracks.size();
  late.view->tracks = std::move(late.tracks);
  late.view->pyramid = std::move(late.pyramids[0]);
  Remember(std::move(late.view), is_keyframe);
  now_.stages_ms["flow"] += watch.Lap();
}

std::vector<LearnedFrontEnd::TrackedPoint> LearnedFrontEnd::FollowToBefore(
    const Sight& from, const std::vector<TrackedPoint>& points) const {
  struct Known {
    cv::Point2f at, moved_by, motion;
  };
  std::vector<Known> known;
  for (const TrackedPoint& track : from.tracks) {
    const auto followed = now_.previous_tracks.find(track.id);
    if (followed != now_.previous_tracks.end()) {
      known.push_back({track.left, followed->second.left - track.left, followed->second.motion});
    }
  }
  std::vector<cv::Point2f> pixels;
  std::vector<cv::Point2f> guesses;
  std::vector<TrackedPoint> followed = points;
  for (TrackedPoint& point : followed) {
    // As its neighbour in the image.
    const auto squared_distance = [&](const Known& one) {
      const cv::Point2f by = one.at - point.left;
      return by.dot(by);
    };
    const auto nearest = std::min_element(
        known.begin(), known.end(),
        [&](const Known& a, const Known& b) { return squared_distance(a) < squared_distance(b); });
    pixels.push_back(point.left);
    guesses.push_back(point.left);
    if (nearest != known.end()) {
      guesses.back() += nearest->moved_by;
      point.motion = nearest->motion;
    }
  }
  if (from.pyramids[0].front().data == now_.previous_pyramid.front().data) {
    return followed;  // It is that frame itself.
  }
  const Flow flow = FollowFinely(
      from.pyramids[0], now_.previous_pyramid, pixels,
      FollowBothWays(from.pyramids[0], now_.previous_pyramid, pixels, guesses, options_.following),
      options_.refinement, options_.max_refinement_px);
  std::vector<TrackedPoint> found;
  for (std::size_t i = 0; i < followed.size(); ++i) {
    if (flow.found[i] != 0) {
      const cv::Point2f by = flow.pixels[i] - pixels[i];
      followed[i].left += by;
      followed[i].right += by;
      found.push_back(followed[i]);
    }
  }
  return found;
}

}  // namespace gluevo::vo
