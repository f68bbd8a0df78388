#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/estimator/sliding_window.h"
#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/geometry/pnp.h"

namespace gluevo::vo {

struct OdometryOptions {
  PnpOptions pnp;
  SlidingWindowOptions window;
  /// Faster motion than this between two frames is a failure, not a motion.
  double max_speed_m_per_s = 60.0;
  double max_turn_deg_per_s = 720.0;

  /// Throws Error naming the option.
  void Validate() const;
};

/// What became of one frame.
struct FrameResult {
  int64_t timestamp_ns = 0;
  /// World frame: the body's at the first frame.
  Rigid3 world_from_body;
  bool is_keyframe = false;
  /// Starts at 0 and grows by one where the pose could not be linked to those before: poses of
  /// different segments have nothing to do with each other.
  int segment = 0;
  int observations = 0;                     ///< Tracks in the frame.
  int tracked = 0;                          ///< Of these, known points (with a depth) from before.
  int stereo = 0;                           ///< Of these, seen by both cameras.
  int inliers = 0;                          ///< Known points that agree with the pose.
  int landmarks = 0;                        ///< Landmarks with a depth in the window.
  TrackedFrame tracked_frame;               ///< What the pose was estimated from.
  std::map<std::string, double> stages_ms;  ///< The front end's, "frontend" and "estimator".
};

/// Stereo visual odometry: a pose for every frame, from this frame and those before it, never
/// revised.
class Odometry {
 public:
  /// Throws Error for options out of their range.
  Odometry(const StereoRig& rig, std::unique_ptr<FrontEnd> frontend,
           const OdometryOptions& options);

  /// The next stereo pair. Throws Error where the time does not increase, and what the front end
  /// throws.
  FrameResult Process(const StereoFrame& frame);

  /// The landmarks of the window that have a depth, as they are known after the last frame.
  std::vector<MapPoint> MapPoints() const { return window_.MapPoints(); }
  /// The rig with the right camera's orientation as the window refined it.
  const StereoRig& rig() const { return window_.rig(); }

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
  SlidingWindow window_;
  int segment_ = 0;
  std::optional<StampedPose> last_, last_but_one_;
};

}  // namespace gluevo::vo
