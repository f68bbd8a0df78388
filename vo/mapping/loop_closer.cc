#include "gluevo/vo/mapping/loop_closer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/seconds.h"

namespace gluevo::vo {

void LoopOptions::Validate() const {
  CheckWithin(interval_s, 0.0, 1e9, "loops.interval_s (--loop-interval)");
  CheckWithin(min_age_s, 0.0, 1e9, "loops.min_age_s (--loop-min-age)");
  CheckWithin(min_similarity, -1.0, 1.0, "loops.min_similarity");
  CheckWithin(min_similarity_share, 0.0, 1.0, "loops.min_similarity_share");
  CheckAtLeast(max_compared, 1, "loops.max_compared");
  CheckAtLeast(max_candidates, 1, "loops.max_candidates (--loop-candidates)");
  verification.Validate();
  consistency.Validate();
}

LoopCloser::LoopCloser(const StereoRig& rig, PlaceCodebook codebook,
                       std::shared_ptr<Matcher> matcher, const LoopOptions& options)
    : rig_(rig), codebook_(std::move(codebook)), matcher_(std::move(matcher)), options_(options) {
  options_.Validate();
}

void LoopCloser::Load(std::vector<LoopKeyframe> keyframes, std::vector<Loop> loops) {
  keyframes_ = std::move(keyframes);
  loops_ = std::move(loops);
  loaded_ = keyframes_.size();
  for (const LoopKeyframe& keyframe : keyframes_) {
    places_.Add(codebook_.Describe(keyframe.features));
  }
}

void LoopCloser::Add(LoopKeyframe keyframe) {
  places_.Add(codebook_.Describe(keyframe.features));
  keyframes_.push_back(std::move(keyframe));
  Verify(FindCandidates());
}

void LoopCloser::SetUp(int segment, const Eigen::Vector3d& up_in_world) {
  up_in_world_[segment] = up_in_world;
}

std::size_t LoopCloser::CountOldEnough() const {
  const LoopKeyframe& query = keyframes_.back();
  std::size_t count = keyframes_.size() - 1;
  while (count > 0 && keyframes_[count - 1].segment == query.segment &&
         SecondsBetween(keyframes_[count - 1].timestamp_ns, query.timestamp_ns) <
             options_.min_age_s) {
    --count;
  }
  return count;
}

std::vector<PlaceIndex::Similar> LoopCloser::FindCandidates() const {
  const LoopKeyframe& query = keyframes_.back();
  const Eigen::VectorXf& place = places_[places_.size() - 1];
  double least = options_.min_similarity;
  if (keyframes_.size() > 1 && keyframes_[keyframes_.size() - 2].segment == query.segment) {
    least = std::max<double>(
        least, options_.min_similarity_share * place.dot(places_[places_.size() - 2]));
  }
  std::vector<PlaceIndex::Similar> candidates = places_.MostSimilar(
      place, CountOldEnough(), static_cast<std::size_t>(options_.max_compared), least);
  if (const std::optional<std::size_t> last = LastBeforeLoss()) {
    std::erase_if(candidates, [&](const auto& other) { return other.place == *last; });
    candidates.insert(candidates.begin(), {*last, place.dot(places_[*last])});
  }
  return candidates;
}

std::optional<std::size_t> LoopCloser::LastBeforeLoss() const {
  if (keyframes_.size() <= loaded_ + 1) {
    return std::nullopt;
  }
  const LoopKeyframe& query = keyframes_.back();
  const std::size_t last = keyframes_.size() - 2;
  return keyframes_[last].segment != query.segment || IsDoubtful(query.motion_covariance)
             ? std::optional(last)
             : std::nullopt;
}

void LoopCloser::Verify(const std::vector<PlaceIndex::Similar>& candidates) {
  const LoopKeyframe& query = keyframes_.back();
  const LoopVerificationOptions& options = options_.verification;
  const std::optional<std::size_t> last = LastBeforeLoss();
  // With how many keypoints look alike.
  std::vector<std::pair<int, PlaceIndex::Similar>> others;
  for (const PlaceIndex::Similar& candidate : candidates) {
    const LoopCheck check = VerifyLoopByNearest(rig_, query, keyframes_[candidate.place], options);
    if (check.measurement && Note(candidate, check)) {
      return;
    }
    if (check.measurement) {
      continue;
    }
    const int alike = candidate.place == last ? std::numeric_limits<int>::max() : check.matches;
    if (alike >= options.min_nearest) {
      others.emplace_back(alike, candidate);
    } else if (&candidate == &candidates.front()) {
      Note(candidate, check);  // The others that are ruled out like this are no news.
    }
  }
  std::stable_sort(others.begin(), others.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  others.resize(
      std::min(others.size(), static_cast<std::size_t>(options_.max_candidates) + (last ? 1 : 0)));
  for (const auto& [alike, candidate] : others) {
    if (Note(candidate, VerifyLoop(rig_, query, keyframes_[candidate.place], *matcher_, options))) {
      return;
    }
  }
}

bool LoopCloser::Note(const PlaceIndex::Similar& candidate, const LoopCheck& check) {
  const LoopKeyframe& old = keyframes_[candidate.place];
  attempts_.push_back({.query_ns = keyframes_.back().timestamp_ns,
                       .candidate_ns = old.timestamp_ns,
                       .is_of_loaded_map = candidate.place < loaded_,
                       .similarity = candidate.similarity,
                       .matches = check.matches,
                       .inliers = check.inliers,
                       .reason = check.reason});
  if (!check.measurement) {
    return false;
  }
  Trust({candidate.place, keyframes_.size() - 1, *check.measurement, check.inliers},
        attempts_.size() - 1);
  return attempts_.back().is_closed;
}

void LoopCloser::Trust(const Loop& loop, std::size_t attempt) {
  unsupported_.push_back(loop);
  unsupported_attempts_.push_back(attempt);
  // One that is trusted may be what another one waits for.
  for (std::size_t i = unsupported_.size(); i-- > 0;) {
    const Loop waiting = unsupported_[i];
    std::vector<Loop> others = loops_;
    for (std::size_t k = 0; k < unsupported_.size(); ++k) {
      if (k != i) {
        others.push_back(unsupported_[k]);
      }
    }
    const LoopTrust trust = Judge(waiting, others, keyframes_, options_.consistency);
    LoopAttempt& told = attempts_[unsupported_attempts_[i]];
    told.is_closed = trust == LoopTrust::kTrusted;
    told.closed_ns = told.is_closed ? keyframes_.back().timestamp_ns : 0;
    told.reason = trust == LoopTrust::kTrusted       ? ""
                  : trust == LoopTrust::kUnsupported ? "no other loop agrees"
                                                     : "the path cannot be as wrong as that";
    if (trust == LoopTrust::kTrusted) {
      loops_.push_back(waiting);
    }
    if (trust != LoopTrust::kUnsupported) {
      unsupported_.erase(unsupported_.begin() + static_cast<std::ptrdiff_t>(i));
      unsupported_attempts_.erase(unsupported_attempts_.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
}

std::vector<Rigid3> LoopCloser::Optimized() const {
  PoseGraph graph = Graph();
  if (!loops_.empty()) {
    OptimizePoseGraph(graph.edges, graph.nodes);
  }
  return PosesOf(graph);
}

}  // namespace gluevo::vo
