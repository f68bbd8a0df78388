#include "gluevo/vo/pipeline/odometry.h"

#include <algorithm>
#include <string>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/core/stopwatch.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "odometry_frame_pose.h"
#include "tracking_ahead.h"

namespace gluevo::vo {
namespace {

// What a front end gives is not trusted: one NaN would spoil the whole window.
TrackedFrame WithoutNonFinite(TrackedFrame frame) {
  std::erase_if(frame.observations, [](const Observation& observation) {
    return !observation.left.allFinite() ||
           (observation.has_right && !observation.right.allFinite());
  });
  return frame;
}

int CountStereo(const TrackedFrame& frame) {
  return static_cast<int>(
      std::count_if(frame.observations.begin(), frame.observations.end(),
                    [](const Observation& observation) { return observation.has_right; }));
}

// Options are checked before anything is made of them.
const OdometryConfig& Checked(const OdometryConfig& config) {
  config.Validate();
  return config;
}

}  // namespace

Odometry::Odometry(const StereoRig& rig, const OdometryConfig& config)
    : pool_(std::make_unique<nn::ThreadPool>(Checked(config).threads)),
      rig_(rig),
      frontend_(MakeFrontEnd(config.frontend, rig, LoadFrontEndNetworks(config.frontend), *pool_)),
      options_(config.odometry),
      window_(std::make_unique<SlidingWindow>(rig, options_.window)),
      noise_(options_.pnp.noise_px, options_.keypoint_noise),
      votes_(options_.votes) {}

Odometry::Odometry(const StereoRig& rig, std::unique_ptr<FrontEnd> frontend,
                   const OdometryOptions& options)
    : rig_(rig),
      frontend_(std::move(frontend)),
      options_(options),
      window_(std::make_unique<SlidingWindow>(rig, options.window)),
      noise_(options.pnp.noise_px, options.keypoint_noise),
      votes_(options.votes) {
  options_.Validate();
}

Odometry::~Odometry() = default;
Odometry::Odometry(Odometry&&) noexcept = default;
Odometry& Odometry::operator=(Odometry&& other) noexcept {
  ahead_ = std::move(other.ahead_);
  announced_ = std::move(other.announced_);
  // The old front end must go before the old pool does.
  frontend_ = std::move(other.frontend_);
  pool_ = std::move(other.pool_);
  rig_ = other.rig_;
  options_ = other.options_;
  window_ = std::move(other.window_);
  history_ = other.history_;
  noise_ = other.noise_;
  votes_ = std::move(other.votes_);
  navigation_ = std::move(other.navigation_);
  expected_ = other.expected_;
  contradictions_ = other.contradictions_;
  uncertainty_ = other.uncertainty_;
  keyframe_ns_ = other.keyframe_ns_;
  last_timestamp_ns_ = other.last_timestamp_ns_;
  segment_ = other.segment_;
  passed_over_ = other.passed_over_;
  return *this;
}

std::vector<MapPoint> Odometry::MapPoints() const { return window_->MapPoints(); }

StereoRig Odometry::rig() const { return window_->rig(); }

FrameResult Odometry::Process(const StereoFrame& frame) {
  CheckTime(frame.timestamp_ns);
  FrameResult result{.timestamp_ns = frame.timestamp_ns};
  Expect(frame.timestamp_ns);
  Track(frame, result);
  StageTimer timer(result.stages_ms);
  const std::optional<FramePose> pose = LocateByAnyWay(result, timer);
  last_timestamp_ns_ = frame.timestamp_ns;
  if (!pose && MayPassOver(result.tracked_frame)) {
    PassOver(result);
  } else {
    const bool is_accepted = BeginAnnounced(/*is_passed_over=*/false);
    const bool is_linked = Enter(pose, result);
    Conclude(is_linked, result);
    if (!is_accepted) {
      frontend_->Accept({.is_keyframe = result.is_keyframe, .starts_segment = !is_linked});
    }
  }
  timer.End("estimator");
  return result;
}

bool Odometry::Enter(std::optional<FramePose> pose, FrameResult& result) {
  const TrackedFrame& tracked = result.tracked_frame;
  const bool is_located = pose.has_value();
  TrackedFrame at_rest = tracked;
  if (is_located) {
    if (navigation_) {
      navigation_->WatchClock({result.timestamp_ns, pose->world_from_body}, window_->has_inertia());
    }
    Judge(at_rest, *pose, result);
    pose->still = Stillness(at_rest);
  } else {
    pose = Bridge(tracked);
  }
  const bool is_linked = pose && Estimate(at_rest, *pose);
  result.is_bridged = is_linked && !is_located;
  if (!is_linked) {
    pose = StartSegment(tracked);
    Estimate(tracked, *pose);
  }
  result.inliers = pose->inliers;
  return is_linked;
}

void Odometry::Conclude(bool is_linked, FrameResult& result) {
  result.world_from_body = window_->world_from_body();
  result.window = window_->Poses();
  result.is_keyframe = window_->newest_is_keyframe();
  Describe(result);
  Rate(is_linked, result);
  window_->Slide();
  FollowInertia(is_linked, result);
  passed_over_ = 0;
  history_.Add({result.timestamp_ns, result.world_from_body}, /*starts_segment=*/!is_linked);
}

void Odometry::CheckTime(int64_t timestamp_ns) const {
  if (last_timestamp_ns_ && timestamp_ns <= *last_timestamp_ns_) {
    throw Error("frame at " + std::to_string(timestamp_ns) +
                " ns does not come after the one before, at " +
                std::to_string(*last_timestamp_ns_) + " ns");
  }
}

bool Odometry::MayPassOver(const TrackedFrame& frame) const {
  if (!history_.last()) {
    return false;
  }
  const double seconds = SecondsBetween(history_.last()->timestamp_ns, frame.timestamp_ns);
  const bool has_something_to_wait_for = window_->CountLandmarks() > 0;
  return CountStereo(frame) < options_.min_stereo ||
         (has_something_to_wait_for &&
          seconds <= (expected_
                          ? std::min(options_.max_predicted_s, options_.inertial.bridge_after_s)
                          : options_.max_predicted_s));
}

void Odometry::PassOver(FrameResult& result) {
  ++passed_over_;
  result.is_predicted = true;
  result.world_from_body = Predict(result.timestamp_ns);
  RateByMotionBefore(result);
  Describe(result);
  frontend_->Accept({.is_passed_over = true});
  BeginAnnounced(/*is_passed_over=*/true);
}

void Odometry::Track(const StereoFrame& frame, FrameResult& result) {
  Stopwatch watch;
  TrackedFrame tracked;
  if (ahead_ && ahead_->has_begun()) {
    internal::TrackingAhead::Tracked done = ahead_->Take();
    tracked = std::move(done.frame);
    result.stages_ms["frontend"] = done.took_ms;
    if (tracked.timestamp_ns != frame.timestamp_ns) {
      throw Error("the frame at " + std::to_string(frame.timestamp_ns) +
                  " ns is not the one that was announced, at " +
                  std::to_string(tracked.timestamp_ns) + " ns");
    }
  } else {
    tracked = frontend_->Track(frame);
    result.stages_ms["frontend"] = watch.Lap();
  }
  result.tracked_frame = WithoutNonFinite(std::move(tracked));
}

void Odometry::Announce(const StereoFrame& next) {
  // What an inertial unit makes the front end expect comes from the estimate.
  if (navigation_ || !frontend_->NeedsOnlyPassedOver() || announced_) {
    return;
  }
  if (!ahead_) {
    ahead_ = std::make_unique<internal::TrackingAhead>();
  }
  announced_ = next;
}

bool Odometry::BeginAnnounced(bool is_passed_over) {
  if (!announced_) {
    return false;
  }
  if (!is_passed_over) {
    frontend_->Accept({});
  }
  ahead_->Begin([frontend = frontend_.get(), frame = *std::exchange(announced_, std::nullopt)] {
    return frontend->Track(frame);
  });
  return true;
}

bool Odometry::Retry(TrackedFrame& tracked) {
  if (window_->empty()) {
    return false;
  }
  std::optional<TrackedFrame> retried = frontend_->Retry();
  if (!retried) {
    return false;
  }
  tracked = WithoutNonFinite(*std::move(retried));
  return true;
}

void Odometry::Judge(TrackedFrame& tracked, FramePose& pose, FrameResult& result) {
  votes_.Learn(tracked, pose.verdicts);
  noise_.Learn(pose.median_error_px);
  TrackedFrame kept{tracked.timestamp_ns, {}, {}};
  std::vector<std::optional<PnpVerdict>> verdicts;
  kept.observations.reserve(tracked.observations.size());
  verdicts.reserve(tracked.observations.size());
  for (std::size_t i = 0; i < tracked.observations.size(); ++i) {
    if (votes_.Moves(tracked.observations[i].track_id)) {
      ++result.moving;
    } else {
      kept.observations.push_back(tracked.observations[i]);
      verdicts.push_back(pose.verdicts[i]);
    }
  }
  result.is_left_only = CountStereo(kept) < options_.min_stereo;
  tracked = std::move(kept);
  pose.verdicts = std::move(verdicts);
}

bool Odometry::Estimate(const TrackedFrame& tracked, const FramePose& pose) {
  window_->AddFrame(tracked, pose.world_from_body, pose.verdicts);
  if (pose.still) {
    window_->HoldStill(*pose.still);
  }
  window_->Triangulate();
  const bool is_solved = window_->Optimize();
  window_->RemoveOutliers();
  return is_solved && IsPlausible(window_->world_from_body(), tracked.timestamp_ns);
}

Odometry::FramePose Odometry::StartSegment(const TrackedFrame& frame) {
  FramePose pose;
  pose.verdicts.resize(frame.observations.size());
  if (history_.last()) {
    // Where the rig was last seen, or was thought to be since, is the best guess there is; the
    // segment number says that it is one.
    pose.world_from_body = passed_over_ > 0 || expected_ ? Predict(frame.timestamp_ns)
                                                         : history_.last()->world_from_body;
    ++segment_;
  }
  votes_.Clear();
  *window_ = SlidingWindow(rig_, options_.window, window_->calibration());
  return pose;
}

void Odometry::Describe(FrameResult& result) const {
  const std::vector<Observation>& observations = result.tracked_frame.observations;
  result.segment = segment_;
  result.observations = static_cast<int>(observations.size());
  result.matched = static_cast<int>(std::count_if(
      observations.begin(), observations.end(),
      [](const Observation& observation) { return observation.tracking_confidence > 0.0F; }));
  result.stereo = CountStereo(result.tracked_frame);
  result.landmarks = static_cast<int>(window_->CountLandmarks());
  result.stages_ms.insert(result.tracked_frame.stages_ms.begin(),
                          result.tracked_frame.stages_ms.end());
}

}  // namespace gluevo::vo
