#include "gluevo/vo/mapping/loop_recorder.h"

#include <algorithm>
#include <map>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/geometry/pose_uncertainty.h"
#include "keyframe_views.h"
#include "linked_segments.h"

namespace gluevo::vo {
namespace {

// Of gravity's direction, radians: what a loop knows of a tilt.
constexpr double kKnownGravity = 2e-3;

// From a to b, which are one pose as two neighbours have it.
Rigid3 Blend(const Rigid3& a, const Rigid3& b, double share) {
  return {a.rotation.slerp(share, b.rotation),
          a.translation + share * (b.translation - a.translation)};
}

}  // namespace

LoopRecorder::LoopRecorder(const StereoRig& rig, PlaceCodebook codebook,
                           std::shared_ptr<FeatureExtractor> extractor,
                           std::shared_ptr<Matcher> matcher, const LoopOptions& options)
    : extractor_(std::move(extractor)),
      matcher_(std::move(matcher)),
      options_(options),
      closer_(rig, std::move(codebook), matcher_, options) {}

void LoopRecorder::Load(const PlaceMap& map, const std::string& map_name) {
  if (!IsSameRig(map.rig, closer_.rig())) {
    throw Error(map_name +
                ": a map of another rig: expected the calibration that it was made with");
  }
  closer_.Load(map.keyframes, map.loops);
  loaded_keyframes_ = map.keyframes.size();
  loaded_segments_ = map.keyframes.empty() ? 0 : map.keyframes.back().segment + 1;
}

bool LoopRecorder::IsLater(int segment, int64_t timestamp_ns) const {
  return closer_.keyframes().empty() || closer_.keyframes().back().segment != segment ||
         SecondsBetween(closer_.keyframes().back().timestamp_ns, timestamp_ns) >=
             options_.interval_s;
}

bool LoopRecorder::IsToBeKept(const FrameResult& result) const {
  return result.is_keyframe && !result.is_predicted &&
         IsLater(loaded_segments_ + result.segment, result.timestamp_ns);
}

void LoopRecorder::Add(const StereoFrame& frame, const FrameResult& result, const StereoRig& rig,
                       KnownFeatures known) {
  const int segment = loaded_segments_ + result.segment;
  const bool starts_segment = frames_.empty() || frames_.back().segment != segment;
  if (starts_segment) {
    for (Pending& last : pending_) {
      if (IsLater(segment - 1, last.result.timestamp_ns)) {
        since_kept_ =
            Compose(since_kept_, last.result.keyframe_from_body, last.result.motion_covariance);
        Keep(std::move(last), segment - 1, rig);
      }
    }
    since_kept_ = PoseCovariance::Zero();
  }
  if (starts_segment || !result.is_predicted) {
    pending_.clear();
  }
  frames_.push_back({{result.timestamp_ns, result.world_from_body}, segment});
  Revise(result.window);
  if (result.inertial && result.inertial->gravity_sigma < kKnownGravity) {
    closer_.SetUp(segment, -result.inertial->gravity_in_world.normalized());
  }
  if (!starts_segment && result.is_keyframe) {
    since_kept_ = Compose(since_kept_, result.keyframe_from_body,
                          result.is_doubtful
                              ? DoubtfulMotion(result.motion_covariance, result.keyframe_from_body)
                              : result.motion_covariance);
  }
  if (frame.images[0].empty()) {
    return;
  }
  if (result.is_predicted) {
    pending_.push_back({frame, result, std::move(known)});
  } else if (IsToBeKept(result)) {
    Keep({frame, result, std::move(known)}, segment, rig);
  }
}

void LoopRecorder::Revise(const Trajectory& window) {
  // The newest key frames are the ones that may be in it.
  const std::vector<LoopKeyframe>& kept = closer_.keyframes();
  auto pose = window.rbegin();
  for (std::size_t i = kept.size(); i > loaded_keyframes_ && pose != window.rend(); --i) {
    const std::size_t keyframe = i - 1;
    while (pose != window.rend() && pose->timestamp_ns > kept[keyframe].timestamp_ns) {
      ++pose;
    }
    if (pose == window.rend() || pose->timestamp_ns != kept[keyframe].timestamp_ns) {
      continue;
    }
    revised_[keyframe - loaded_keyframes_] = pose->world_from_body;
    for (const std::size_t end : {keyframe, keyframe + 1}) {
      if (end > loaded_keyframes_ && end < kept.size() &&
          kept[end].segment == kept[end - 1].segment) {
        closer_.Revise(end, revised_[end - 1 - loaded_keyframes_].Inverse() *
                                revised_[end - loaded_keyframes_]);
      }
    }
  }
}

void LoopRecorder::Keep(Pending kept, int segment, const StereoRig& rig) {
  const FrameResult& result = kept.result;
  LoopKeyframe keyframe{.timestamp_ns = result.timestamp_ns,
                        .segment = segment,
                        .world_from_body = result.world_from_body,
                        .motion_covariance = since_kept_};
  internal::FindKeypoints(kept.frame, std::move(kept.known), rig, *extractor_, *matcher_,
                          options_.verification.match_threshold, keyframe);
  if (!revised_.empty() && closer_.keyframes().back().segment == segment) {
    keyframe.motion = revised_.back().Inverse() * result.world_from_body;
  }
  revised_.push_back(result.world_from_body);
  closer_.Add(std::move(keyframe));
  since_kept_ = PoseCovariance::Zero();
}

GlobalAdjustment LoopRecorder::Adjust(const std::vector<Rigid3>& keyframes,
                                      const GlobalAdjustmentOptions& options) const {
  return AdjustGlobally(closer_, keyframes, *matcher_, options);
}

Trajectory LoopRecorder::Follow(const std::vector<Rigid3>& keyframes) const {
  const std::vector<LoopKeyframe>& kept = closer_.keyframes();
  Trajectory trajectory;
  trajectory.reserve(frames_.size());
  std::size_t next = loaded_keyframes_;  // The first kept one after the frame.
  for (const Frame& frame : frames_) {
    while (next < kept.size() && kept[next].timestamp_ns <= frame.pose.timestamp_ns) {
      ++next;
    }
    const auto by = [&](std::size_t i) {
      return keyframes[i] * (kept[i].world_from_body.Inverse() * frame.pose.world_from_body);
    };
    const bool has_before = next > loaded_keyframes_ && kept[next - 1].segment == frame.segment;
    const bool has_after = next < kept.size() && kept[next].segment == frame.segment;
    Rigid3 pose = frame.pose.world_from_body;
    if (has_before && has_after) {
      const double share =
          static_cast<double>(frame.pose.timestamp_ns - kept[next - 1].timestamp_ns) /
          static_cast<double>(kept[next].timestamp_ns - kept[next - 1].timestamp_ns);
      pose = Blend(by(next - 1), by(next), share);
    } else if (has_before || has_after) {
      pose = by(has_before ? next - 1 : next);
    }
    trajectory.push_back({frame.pose.timestamp_ns, pose});
  }
  return trajectory;
}

std::vector<int> LoopRecorder::LinkedSegments() const {
  const std::map<int, internal::LinkedSegment> segments =
      internal::LinkSegments(closer_.keyframes(), closer_.loops());
  std::vector<int> linked;
  linked.reserve(frames_.size());
  for (const Frame& frame : frames_) {
    const auto segment = segments.find(frame.segment);
    linked.push_back(segment == segments.end() ? frame.segment : segment->second.root);
  }
  return linked;
}

int LoopRecorder::JoinedSegments() const {
  int joined = 0;
  for (const auto& [number, segment] :
       internal::LinkSegments(closer_.keyframes(), closer_.loops())) {
    joined += number >= loaded_segments_ && segment.root != number ? 1 : 0;
  }
  return joined;
}

std::size_t LoopRecorder::FramesInLoadedMap() const {
  const std::vector<int> linked = LinkedSegments();
  return static_cast<std::size_t>(std::count_if(
      linked.begin(), linked.end(), [&](int segment) { return segment < loaded_segments_; }));
}

}  // namespace gluevo::vo
