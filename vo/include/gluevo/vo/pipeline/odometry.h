#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "gluevo/vo/core/frame_result.h"
#include "gluevo/vo/core/map_point.h"
#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/estimator/sliding_window_options.h"
#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/geometry/pnp.h"

namespace gluevo::vo {

class SlidingWindow;

struct OdometryOptions {
  PnpOptions pnp;
  SlidingWindowOptions window;
  /// Faster motion than this between two frames is a failure, not a motion.
  double max_speed_m_per_s = 60.0;
  double max_turn_deg_per_s = 720.0;

  /// Throws Error naming the option.
  void Validate() const;
};

/// Stereo visual odometry: a pose for every frame, from this frame and those before it, never
/// revised.
class Odometry {
 public:
  /// Throws Error for options out of their range.
  Odometry(const StereoRig& rig, std::unique_ptr<FrontEnd> frontend,
           const OdometryOptions& options);
  ~Odometry();
  Odometry(Odometry&&) noexcept;
  Odometry& operator=(Odometry&&) noexcept;

  /// The next stereo pair. Throws Error where the time does not increase, and what the front end
  /// throws.
  FrameResult Process(const StereoFrame& frame);

  /// The landmarks of the window that have a depth, as they are known after the last frame.
  std::vector<MapPoint> MapPoints() const;
  /// The rig with the right camera's orientation as the window refined it.
  const StereoRig& rig() const;

 private:
  struct FramePose {
    Rigid3 world_from_body;
    int inliers = 0;
    std::vector<std::optional<PnpVerdict>> verdicts;  // one an observation, where it was judged
  };
  void CheckTime(int64_t timestamp_ns) const;
  /// Another way to match the frame that the front end gave last; false where there is none.
  bool Retry(TrackedFrame& tracked);
  /// Takes the frame into the window. False where the estimate diverges.
  bool Estimate(const TrackedFrame& tracked, const FramePose& pose);
  void Describe(const FramePose& pose, FrameResult& result) const;
  std::optional<FramePose> Locate(const TrackedFrame& frame) const;
  bool IsPlausible(const Rigid3& world_from_body, int64_t timestamp_ns) const;
  FramePose StartSegment(const TrackedFrame& frame);

  StereoRig rig_;
  std::unique_ptr<FrontEnd> frontend_;
  OdometryOptions options_;
  std::unique_ptr<SlidingWindow> window_;  // Never absent.
  int segment_ = 0;
  std::optional<StampedPose> last_, last_but_one_;
};

}  // namespace gluevo::vo
