#include "gluevo/vo/pipeline/odometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/stopwatch.h"
#include "gluevo/vo/estimator/sliding_window.h"

namespace gluevo::vo {
namespace {

bool IsFinite(const Rigid3& pose) {
  return pose.translation.allFinite() && pose.rotation.coeffs().allFinite();
}

// What a front end gives is not trusted: one NaN would spoil the whole window.
TrackedFrame WithoutNonFinite(TrackedFrame frame) {
  std::erase_if(frame.observations, [](const Observation& observation) {
    return !observation.left.allFinite() ||
           (observation.has_right && !observation.right.allFinite());
  });
  return frame;
}

}  // namespace

void OdometryOptions::Validate() const {
  pnp.Validate();
  window.Validate();
  CheckPositive(max_speed_m_per_s, "max_speed_m_per_s");
  CheckPositive(max_turn_deg_per_s, "max_turn_deg_per_s");
}

Odometry::Odometry(const StereoRig& rig, std::unique_ptr<FrontEnd> frontend,
                   const OdometryOptions& options)
    : rig_(rig),
      frontend_(std::move(frontend)),
      options_(options),
      window_(std::make_unique<SlidingWindow>(rig, options.window)) {
  options_.Validate();
}

Odometry::~Odometry() = default;
Odometry::Odometry(Odometry&&) noexcept = default;
Odometry& Odometry::operator=(Odometry&&) noexcept = default;

std::vector<MapPoint> Odometry::MapPoints() const { return window_->MapPoints(); }

const StereoRig& Odometry::rig() const { return window_->rig(); }

FrameResult Odometry::Process(const StereoFrame& frame) {
  CheckTime(frame.timestamp_ns);
  Stopwatch watch;
  FrameResult result{.timestamp_ns = frame.timestamp_ns};
  TrackedFrame& tracked = result.tracked_frame;
  tracked = WithoutNonFinite(frontend_->Track(frame));
  result.stages_ms["frontend"] = watch.Lap();

  std::optional<FramePose> pose = Locate(tracked);
  result.stages_ms["estimator"] = watch.Lap();
  while (!pose && Retry(tracked)) {
    result.stages_ms["frontend"] += watch.Lap();
    pose = Locate(tracked);
    result.stages_ms["estimator"] += watch.Lap();
  }
  if (!pose || !Estimate(tracked, *pose)) {
    pose = StartSegment(tracked);
    Estimate(tracked, *pose);
  }
  Describe(*pose, result);
  window_->Slide();
  result.stages_ms["estimator"] += watch.Lap();

  frontend_->Accept(result.is_keyframe);
  last_but_one_ = std::exchange(last_, StampedPose{frame.timestamp_ns, result.world_from_body});
  return result;
}

void Odometry::CheckTime(int64_t timestamp_ns) const {
  if (last_ && timestamp_ns <= last_->timestamp_ns) {
    throw Error("frame at " + std::to_string(timestamp_ns) +
                " ns does not come after the one before, at " +
                std::to_string(last_->timestamp_ns) + " ns");
  }
}

bool Odometry::Retry(TrackedFrame& tracked) {
  if (window_->empty()) {
    return false;
  }
  std::optional<TrackedFrame> retried = frontend_->Retry();
  if (retried) {
    tracked = WithoutNonFinite(*std::move(retried));
  }
  return retried.has_value();
}

bool Odometry::Estimate(const TrackedFrame& tracked, const FramePose& pose) {
  window_->AddFrame(tracked, pose.world_from_body, pose.verdicts);
  window_->Triangulate();
  const bool is_solved = window_->Optimize();
  window_->RemoveOutliers();
  return is_solved && (!last_ || IsPlausible(window_->world_from_body(), tracked.timestamp_ns));
}

void Odometry::Describe(const FramePose& pose, FrameResult& result) const {
  const std::vector<Observation>& observations = result.tracked_frame.observations;
  result.world_from_body = window_->world_from_body();
  result.is_keyframe = window_->newest_is_keyframe();
  result.segment = segment_;
  result.observations = static_cast<int>(observations.size());
  result.tracked = static_cast<int>(std::count_if(pose.verdicts.begin(), pose.verdicts.end(),
                                                  [](const auto& v) { return v.has_value(); }));
  result.stereo = static_cast<int>(
      std::count_if(observations.begin(), observations.end(),
                    [](const Observation& observation) { return observation.has_right; }));
  result.inliers = pose.inliers;
  result.landmarks = static_cast<int>(window_->CountLandmarks());
  result.stages_ms.insert(result.tracked_frame.stages_ms.begin(),
                          result.tracked_frame.stages_ms.end());
}

std::optional<Odometry::FramePose> Odometry::Locate(const TrackedFrame& frame) const {
  if (window_->empty()) {
    return std::nullopt;
  }
  const std::vector<SlidingWindow::Correspondence> correspondences =
      window_->Correspond(frame, options_.pnp.noise);
  std::vector<PnpObservation> observations;
  observations.reserve(correspondences.size());
  for (const SlidingWindow::Correspondence& correspondence : correspondences) {
    observations.push_back(correspondence.pnp);
  }
  // Guesses only: RANSAC finds motions that are neither rest nor the last one repeated.
  std::vector<Rigid3> guesses = {last_->world_from_body};
  if (last_but_one_) {
    guesses.push_back(last_->world_from_body * last_but_one_->world_from_body.Inverse() *
                      last_->world_from_body);
  }
  const std::optional<PnpResult> pnp =
      SolvePnp(window_->rig(), observations, guesses, options_.pnp);
  if (!pnp || !IsPlausible(pnp->world_from_body, frame.timestamp_ns)) {
    return std::nullopt;
  }
  FramePose pose{pnp->world_from_body, pnp->inliers, {}};
  pose.verdicts.resize(frame.observations.size());
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    pose.verdicts[correspondences[i].observation] = pnp->verdicts[i];
  }
  return pose;
}

bool Odometry::IsPlausible(const Rigid3& world_from_body, int64_t timestamp_ns) const {
  const double seconds = static_cast<double>(timestamp_ns - last_->timestamp_ns) * 1e-9;
  const Rigid3 motion = last_->world_from_body.Inverse() * world_from_body;
  const double turn_deg =
      motion.rotation.angularDistance(Eigen::Quaterniond::Identity()) * 180.0 / std::numbers::pi;
  return IsFinite(world_from_body) &&
         motion.translation.norm() <= options_.max_speed_m_per_s * seconds &&
         (turn_deg <= options_.max_turn_deg_per_s * seconds);
}

Odometry::FramePose Odometry::StartSegment(const TrackedFrame& frame) {
  FramePose pose;
  pose.verdicts.resize(frame.observations.size());
  if (last_) {
    // Where the rig was last seen is the best guess there is; the segment number says that it is
    // one.
    pose.world_from_body = last_->world_from_body;
    ++segment_;
  }
  last_but_one_.reset();
  *window_ = SlidingWindow(rig_, options_.window);
  return pose;
}

}  // namespace gluevo::vo
