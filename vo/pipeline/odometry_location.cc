#include <vector>

#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/core/stopwatch.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "odometry_frame_pose.h"

// Where a frame is, by what was seen before.
namespace gluevo::vo {

std::optional<Odometry::FramePose> Odometry::LocateByAnyWay(FrameResult& result,
                                                            StageTimer& timer) {
  TrackedFrame& tracked = result.tracked_frame;
  std::optional<FramePose> pose = Locate(tracked, result);
  timer.End("estimator");
  while (!pose && Retry(tracked)) {
    timer.End("frontend");
    pose = Locate(tracked, result);
    timer.End("estimator");
  }
  HeedContradictions(pose.has_value(), result);
  return pose;
}

std::optional<Odometry::FramePose> Odometry::Locate(const TrackedFrame& frame,
                                                    FrameResult& result) const {
  if (window_->empty()) {
    return std::nullopt;
  }
  std::optional<FramePose> pose = LocateWithin(noise_.px(), frame, result);
  // A jolt after sharp images: keypoints are worse at once, which is learned slowly.
  if (!pose && noise_.px() < options_.pnp.noise_px) {
    pose = LocateWithin(options_.pnp.noise_px, frame, result);
  }
  return pose;
}

std::optional<Odometry::FramePose> Odometry::LocateWithin(double noise_px,
                                                          const TrackedFrame& frame,
                                                          FrameResult& result) const {
  std::vector<SlidingWindow::Correspondence> correspondences =
      window_->Correspond(frame, FromReferencePx(noise_px));
  std::erase_if(correspondences, [&](const SlidingWindow::Correspondence& correspondence) {
    return votes_.Moves(frame.observations[correspondence.observation].track_id);
  });
  std::vector<PnpObservation> observations;
  std::vector<const Observation*> seen;
  observations.reserve(correspondences.size());
  seen.reserve(correspondences.size());
  for (const SlidingWindow::Correspondence& correspondence : correspondences) {
    observations.push_back(correspondence.pnp);
    seen.push_back(&frame.observations[correspondence.observation]);
  }
  votes_.Assign(seen, rig_.cameras[0].width, observations);
  result.tracked = static_cast<int>(observations.size());
  PnpOptions options = options_.pnp;
  options.noise_px = noise_px;
  const std::optional<PnpResult> pnp =
      SolvePnp(rig_, observations, Guesses(frame.timestamp_ns), options);
  if (!pnp) {
    return std::nullopt;
  }
  if (!IsPlausible(pnp->world_from_body, frame.timestamp_ns)) {
    result.refused_speed_m_per_s = SpeedTo(pnp->world_from_body, frame.timestamp_ns);
    return std::nullopt;
  }
  if (Contradicts(*pnp)) {
    result.is_refused_by_inertia = true;
    return std::nullopt;
  }
  result.is_doubtful = pnp->vote_share < options_.votes.doubtful_share;
  FramePose pose{pnp->world_from_body, pnp->inliers, {}, pnp->median_error_px};
  pose.verdicts.resize(frame.observations.size());
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    pose.verdicts[correspondences[i].observation] = pnp->verdicts[i];
  }
  return pose;
}

}  // namespace gluevo::vo
