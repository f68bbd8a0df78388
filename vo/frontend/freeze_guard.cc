#include "gluevo/vo/frontend/freeze_guard.h"

#include <opencv2/core.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

#include "gluevo/vo/core/median.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/seconds.h"

namespace gluevo::vo {
namespace {

// Median over the tracks of both frames, pixels; 0 where they share none.
double MotionPx(const TrackedFrame& from, const TrackedFrame& to) {
  std::unordered_map<int64_t, Eigen::Vector2d> before;
  for (const Observation& observation : from.observations) {
    before[observation.track_id] = observation.left_pixel;
  }
  std::vector<double> motions;
  for (const Observation& observation : to.observations) {
    const auto found = before.find(observation.track_id);
    if (found != before.end()) {
      motions.push_back((observation.left_pixel - found->second).norm());
    }
  }
  return Median(std::move(motions));
}

}  // namespace

void FreezeGuardOptions::Validate() const {
  CheckPositive(max_difference, "freeze.max_difference");
  CheckPositive(min_motion_px, "freeze.min_motion_px");
  CheckPositive(max_frozen_s, "freeze.max_frozen_s");
}

FreezeGuard::FreezeGuard(std::unique_ptr<FrontEnd> guarded, const FreezeGuardOptions& options)
    : guarded_(std::move(guarded)), options_(options) {
  options_.Validate();
}

TrackedFrame FreezeGuard::Track(const StereoFrame& frame) {
  const std::optional<ExpectedView> expected = std::exchange(expected_, std::nullopt);
  is_frozen_ = IsFrozen(frame, 0);
  if (is_frozen_) {
    newest_ = frame;
    return {frame.timestamp_ns, {}, {}};
  }
  StereoFrame given = frame;
  if (IsFrozen(frame, 1)) {
    given.images[1] = cv::Mat::zeros(frame.images[1].size(), frame.images[1].type());
  }
  if (expected) {
    guarded_->Expect(*expected);
  }
  TrackedFrame tracked = guarded_->Track(given);
  newest_ = frame;
  last_changed_ns_ = frame.timestamp_ns;
  tracked_ = tracked;
  return tracked;
}

std::optional<TrackedFrame> FreezeGuard::Retry() {
  if (is_frozen_) {
    return std::nullopt;
  }
  std::optional<TrackedFrame> tracked = guarded_->Retry();
  if (tracked) {
    tracked_ = *tracked;
  }
  return tracked;
}

void FreezeGuard::Accept(const FrameOutcome& outcome) {
  if (is_frozen_) {
    guarded_->PassOver();
    return;
  }
  if (!outcome.is_passed_over) {
    is_moving_ = MotionPx(accepted_, tracked_) >= options_.min_motion_px;
    accepted_ = std::move(tracked_);
  }
  guarded_->Accept(outcome);
}

void FreezeGuard::PassOver() { guarded_->PassOver(); }

bool FreezeGuard::IsFrozen(const StereoFrame& frame, std::size_t camera) const {
  const cv::Mat& image = frame.images[camera];
  const cv::Mat& before = newest_.images[camera];
  const double seconds = SecondsBetween(last_changed_ns_, frame.timestamp_ns);
  if (!is_moving_ || image.empty() || image.size() != before.size() ||
      image.type() != before.type() || seconds > options_.max_frozen_s) {
    return false;
  }
  const double difference =
      cv::norm(image, before, cv::NORM_L1) / static_cast<double>(image.total());
  return difference < options_.max_difference;
}

}  // namespace gluevo::vo
