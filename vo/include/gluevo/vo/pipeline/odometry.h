#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/core/expected_view.h"
#include "gluevo/vo/core/frame_result.h"
#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/core/map_point.h"
#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/pipeline/inertial_navigation.h"
#include "gluevo/vo/pipeline/keypoint_noise.h"
#include "gluevo/vo/pipeline/motion_history.h"
#include "gluevo/vo/pipeline/odometry_config.h"
#include "gluevo/vo/pipeline/path_uncertainty.h"
#include "gluevo/vo/pipeline/track_votes.h"

namespace gluevo::vo {

class SlidingWindow;
class StageTimer;
namespace internal {
class TrackingAhead;
}

/// Stereo odometry, with an inertial unit where there is one: a pose for every frame, from this
/// frame and those before it, never revised.
class Odometry {
 public:
  /// The front end that the options name, with its networks and threads. Throws Error for options
  /// out of their range and for weights that cannot be read.
  Odometry(const StereoRig& rig, const OdometryConfig& config);
  /// A front end of one's own. Throws Error for options out of their range.
  Odometry(const StereoRig& rig, std::unique_ptr<FrontEnd> frontend,
           const OdometryOptions& options);
  ~Odometry();
  Odometry(Odometry&&) noexcept;
  Odometry& operator=(Odometry&&) noexcept;

  /// From the next frame on readings of an inertial unit are used, once the frames bear out a
  /// start. Its frame is the rig's body; `noise` is what its calibration says. Throws Error for
  /// figures out of range, and where the window's solver is another than "gluevo".
  void UseImu(const ImuNoise& noise);
  /// The unit's next readings, in order of time (Error where they are not). Those up to a frame's
  /// time, and one beyond, have to be there before it; what comes later does not count for it.
  /// UseImu() goes before.
  void AddImu(std::span<const ImuSample> samples);
  /// How the unit stands; null without one.
  const InertialNavigation* inertial() const { return navigation_.get(); }

  /// Before Process(): the frame after the one that is given to it next. Where the front end can
  /// (FrontEnd::NeedsOnlyPassedOver), it is tracked on a thread of its own while that one is
  /// estimated; results are the same. It has to be the next one then. Does nothing where the front
  /// end cannot, or a frame has been announced already.
  void Announce(const StereoFrame& next);
  /// The next stereo pair. Throws Error where the time does not increase, and what the front end
  /// throws.
  FrameResult Process(const StereoFrame& frame);

  /// The landmarks of the window that have a depth, as they are known after the last frame.
  std::vector<MapPoint> MapPoints() const;
  /// The rig with the right camera's orientation as the window refined it.
  StereoRig rig() const;

 private:
  struct FramePose;
  /// Where the inertial unit leads, with its covariance (of the motion since the last pose).
  struct Expectation {
    Rigid3 world_from_body;
    PoseCovariance covariance;
  };

  void CheckTime(int64_t timestamp_ns) const;
  void Track(const StereoFrame& frame, FrameResult& result);
  /// The front end may be told that the frame is not passed over, and go on to the one announced.
  /// False where it has to wait for the outcome.
  bool BeginAnnounced(bool is_passed_over);
  /// Another way to match the frame that the front end gave last; false where there is none.
  bool Retry(TrackedFrame& tracked);
  /// By what the front end found, or finds by its other ways.
  std::optional<FramePose> LocateByAnyWay(FrameResult& result, StageTimer& timer);
  /// Also says in `result` what it was located by.
  std::optional<FramePose> Locate(const TrackedFrame& frame, FrameResult& result) const;
  /// The same where keypoints have a standard deviation of `noise_px`, of kReferenceFocalPx.
  std::optional<FramePose> LocateWithin(double noise_px, const TrackedFrame& frame,
                                        FrameResult& result) const;
  /// What the votes say of the frame's tracks, and what is left for the estimate.
  void Judge(TrackedFrame& tracked, FramePose& pose, FrameResult& result);
  /// Whether a frame that cannot be located is no reason to give up what is known.
  bool MayPassOver(const TrackedFrame& frame) const;
  void PassOver(FrameResult& result);
  /// Takes the frame into the window with a pose, the inertial unit's where it has none, or as the
  /// first of a new segment. False where it is that.
  bool Enter(std::optional<FramePose> pose, FrameResult& result);
  /// What comes out of it, and the way made free for the next frame.
  void Conclude(bool is_linked, FrameResult& result);
  /// Takes the frame into the window. False where the estimate diverges.
  bool Estimate(const TrackedFrame& tracked, const FramePose& pose);
  FramePose StartSegment(const TrackedFrame& frame);
  /// Where the inertial unit leads, for the front end, too.
  void Expect(int64_t timestamp_ns);
  std::optional<ExpectedView> ExpectView(int64_t timestamp_ns) const;
  /// Where a frame may be, for RANSAC.
  std::vector<Rigid3> Guesses(int64_t timestamp_ns) const;
  Rigid3 Predict(int64_t timestamp_ns) const;
  /// A frame that shows nothing known where the inertial unit leads; nothing where that is not
  /// known well enough.
  std::optional<FramePose> Bridge(const TrackedFrame& frame) const;
  /// Whether a pose that was found is far from where the inertial unit leads.
  bool Contradicts(const PnpResult& pnp) const;
  /// Of a frame that is located, or not: where one pose after the other contradicts the inertial
  /// unit, that has to start again.
  void HeedContradictions(bool is_located, const FrameResult& result);
  /// That the body stood still since the frame before; nothing without a unit.
  std::optional<StillFactor> Stillness(const TrackedFrame& frame);
  /// Starts the inertial unit where it may, and says what is known of it.
  void FollowInertia(bool is_linked, FrameResult& result);
  InertialEstimate DescribeInertia() const;
  void Describe(FrameResult& result) const;
  /// How good the located pose is ...
  void Rate(bool is_linked, FrameResult& result);
  /// ... and one that only the motion before says something of.
  void RateByMotionBefore(FrameResult& result) const;
  /// Of a motion from the last pose, metres a second.
  double SpeedTo(const Rigid3& world_from_body, int64_t timestamp_ns) const;
  bool IsPlausible(const Rigid3& world_from_body, int64_t timestamp_ns) const;

  std::unique_ptr<nn::ThreadPool> pool_;  // Outlives the front end; absent for a user's own.
  StereoRig rig_;
  std::unique_ptr<FrontEnd> frontend_;
  OdometryOptions options_;
  std::unique_ptr<SlidingWindow> window_;  // Never absent.
  MotionHistory history_;
  KeypointNoise noise_;
  TrackVotes votes_;
  std::unique_ptr<InertialNavigation> navigation_;  // Absent without an inertial unit.
  std::optional<Expectation> expected_;             // Of the frame in work.
  int contradictions_ = 0;                          // Frames in sequence that contradict it.
  PathUncertainty uncertainty_;
  int64_t keyframe_ns_ = 0;                   // The newest.
  std::optional<int64_t> last_timestamp_ns_;  // Of frames that were passed over, too.
  int segment_ = 0;
  int passed_over_ = 0;                             // Frames since the last one that was not.
  std::optional<StereoFrame> announced_;            // Until its tracking begins.
  std::unique_ptr<internal::TrackingAhead> ahead_;  // Absent until a frame is announced. Last:
                                                    // its thread uses the front end.
};

}  // namespace gluevo::vo
