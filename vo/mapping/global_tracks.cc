#include "global_tracks.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "gluevo/vo/core/reference_focal.h"

namespace gluevo::vo::internal {
namespace {

// Which keypoints of all key frames show one point (union-find).
class Sets {
 public:
  explicit Sets(const std::vector<LoopKeyframe>& keyframes) {
    std::size_t count = 0;
    for (const LoopKeyframe& keyframe : keyframes) {
      begins_.push_back(count);
      count += keyframe.keypoints.size();
    }
    parents_.resize(count);
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
  }

  void Join(const KeyframeView& a, const KeyframeView& b) {
    const std::size_t of_a = Root(begins_[a.keyframe] + a.keypoint);
    const std::size_t of_b = Root(begins_[b.keyframe] + b.keypoint);
    parents_[std::max(of_a, of_b)] = std::min(of_a, of_b);
  }

  std::size_t RootOf(const KeyframeView& view) {
    return Root(begins_[view.keyframe] + view.keypoint);
  }

 private:
  std::size_t Root(std::size_t i) {
    while (parents_[i] != i) {
      parents_[i] = parents_[parents_[i]];
      i = parents_[i];
    }
    return i;
  }

  std::vector<std::size_t> begins_;  // Of each key frame's keypoints.
  std::vector<std::size_t> parents_;
};

std::vector<std::pair<std::size_t, std::size_t>> PairsOf(const LoopCloser& closer) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const std::vector<LoopKeyframe>& keyframes = closer.keyframes();
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    for (const std::size_t step : {std::size_t{1}, std::size_t{2}}) {
      if (i + step < keyframes.size() && keyframes[i].segment == keyframes[i + step].segment) {
        pairs.emplace_back(i, i + step);
      }
    }
  }
  for (const Loop& loop : closer.loops()) {
    pairs.emplace_back(loop.candidate, loop.query);
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

// Whether the poses put the keypoint `from` to about where `to` sees it. One without depth may be
// anywhere.
bool Fits(const LoopCloser& closer, const std::vector<Rigid3>& world_from_body,
          const KeyframeView& from, const KeyframeView& to, double max_error) {
  const StereoKeypoint& known = closer.keyframes()[from.keyframe].keypoints[from.keypoint];
  const StereoKeypoint& seen = closer.keyframes()[to.keyframe].keypoints[to.keypoint];
  if (known.inverse_depth <= 0.0) {
    return known.left.allFinite() && seen.left.allFinite();
  }
  const Rigid3 world_from_cam = world_from_body[to.keyframe] * closer.rig().body_from_cam[0];
  const Eigen::Vector3d in_cam =
      world_from_cam.Inverse() * PointInWorld(closer, world_from_body, from);
  return in_cam.z() > 0.0 && (in_cam.hnormalized() - seen.left).norm() <= max_error;
}

}  // namespace

Eigen::Vector3d PointInWorld(const LoopCloser& closer, const std::vector<Rigid3>& world_from_body,
                             const KeyframeView& view) {
  const StereoKeypoint& keypoint = closer.keyframes()[view.keyframe].keypoints[view.keypoint];
  return world_from_body[view.keyframe] *
         (closer.rig().body_from_cam[0] * (keypoint.left.homogeneous() / keypoint.inverse_depth));
}

std::vector<GlobalTrack> FindTracks(const LoopCloser& closer,
                                    const std::vector<Rigid3>& world_from_body, Matcher& matcher,
                                    const GlobalAdjustmentOptions& options) {
  const std::vector<LoopKeyframe>& keyframes = closer.keyframes();
  const double max_error = FromReferencePx(options.max_error_px);
  Sets sets(keyframes);
  for (const auto& [a, b] : PairsOf(closer)) {
    const nn::Matches matches =
        matcher.Match(keyframes[a].features, keyframes[b].features, options.match_threshold);
    for (std::size_t i = 0; i < matches.matches0.size(); ++i) {
      if (matches.matches0[i] < 0) {
        continue;
      }
      const KeyframeView in_a{a, i};
      const KeyframeView in_b{b, static_cast<std::size_t>(matches.matches0[i])};
      if (Fits(closer, world_from_body, in_a, in_b, max_error) &&
          Fits(closer, world_from_body, in_b, in_a, max_error)) {
        sets.Join(in_a, in_b);
      }
    }
  }
  std::map<std::size_t, GlobalTrack> tracks;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    for (std::size_t i = 0; i < keyframes[k].keypoints.size(); ++i) {
      tracks[sets.RootOf({k, i})].push_back({k, i});
    }
  }
  std::vector<GlobalTrack> found;
  for (auto& [root, track] : tracks) {
    const bool is_ambiguous =
        std::adjacent_find(track.begin(), track.end(), [](const auto& a, const auto& b) {
          return a.keyframe == b.keyframe;
        }) != track.end();
    const bool has_depth = std::any_of(track.begin(), track.end(), [&](const auto& view) {
      return keyframes[view.keyframe].keypoints[view.keypoint].inverse_depth > 0.0;
    });
    if (track.size() > 1 && !is_ambiguous && has_depth) {
      found.push_back(std::move(track));
    }
  }
  return found;
}

}  // namespace gluevo::vo::internal
