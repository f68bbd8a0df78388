#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "gluevo/vo/core/tracked_frame.h"
#include "gluevo/vo/frontend/frontend.h"

namespace gluevo::vo {

struct FreezeGuardOptions {
  /// Two images are the same where their gray values differ by less than this on average. Sensor
  /// noise of one gray level makes two views of a scene at rest differ by 1.1.
  double max_difference = 0.25;
  /// Of a rig that moved less than this from the frame before the last to the last, median over
  /// tracks, equal images are rest, pixels.
  double min_motion_px = 1.0;
  /// After so long equal images are rest, whatever was before, seconds.
  double max_frozen_s = 5.0;

  /// Throws Error naming the option.
  void Validate() const;
};

/// Keeps images that a camera gives twice from the front end behind it: taken for a view of their
/// own they say that the rig, which was moving, stands still. Where the left image is the one
/// before again, the frame has no observations. Where only the right one is, it is given on as
/// black: what it shows is not what the left camera sees.
class FreezeGuard final : public FrontEnd {
 public:
  /// Throws Error for options out of their range.
  FreezeGuard(std::unique_ptr<FrontEnd> guarded, const FreezeGuardOptions& options);

  void Expect(const ExpectedView& view) override { expected_ = view; }
  TrackedFrame Track(const StereoFrame& frame) override;
  std::optional<TrackedFrame> Retry() override;
  void Accept(const FrameOutcome& outcome) override;
  bool NeedsOnlyPassedOver() const override { return guarded_->NeedsOnlyPassedOver(); }
  void PassOver() override;

 private:
  bool IsFrozen(const StereoFrame& frame, std::size_t camera) const;

  std::unique_ptr<FrontEnd> guarded_;
  FreezeGuardOptions options_;
  std::optional<ExpectedView> expected_;  // Of the frame that comes.
  StereoFrame newest_;
  TrackedFrame tracked_;         // The newest that the front end gave.
  TrackedFrame accepted_;        // The newest before it that was not passed over.
  int64_t last_changed_ns_ = 0;  // Of the newest frame whose left image was another.
  bool is_moving_ = false;
  bool is_frozen_ = false;
};

}  // namespace gluevo::vo
