#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "gluevo/vo/core/map_point.h"
#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/core/tracked_frame.h"
#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/estimator/learned_right_camera.h"
#include "gluevo/vo/estimator/pose_prior.h"
#include "gluevo/vo/estimator/sliding_window_options.h"
#include "gluevo/vo/estimator/views_noise.h"
#include "gluevo/vo/geometry/pnp.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/inertial/gravity.h"
#include "gluevo/vo/inertial/imu_readings.h"
#include "gluevo/vo/inertial/inertial_factor.h"
#include "gluevo/vo/inertial/initialisation.h"
#include "gluevo/vo/inertial/still_factor.h"

namespace gluevo::vo {

struct WindowProblem;
struct WindowSolverLimits;

/// Poses and landmarks of the newest frames, estimated together (Qin et al. 2018, section VI); once
/// an inertial unit has started their velocities, its biases and gravity, too. Landmarks are known
/// by bearing and inverse depth in their anchor, the left view of the first frame in the window
/// that sees them. The oldest pose stays fixed: it is the gauge.
class SlidingWindow {
 public:
  /// `so_far`: what earlier windows of the same rig found.
  SlidingWindow(const StereoRig& rig, const SlidingWindowOptions& options,
                const LearnedRightCamera& so_far = {});
  ~SlidingWindow();
  SlidingWindow(SlidingWindow&&) noexcept;
  SlidingWindow& operator=(SlidingWindow&&) noexcept;

  bool empty() const { return frames_.empty(); }
  /// The rig with the right camera turned as calibration() says.
  StereoRig rig() const;
  /// As the last Optimize() has it, its sigma as the last MotionSinceKeyframe().
  const LearnedRightCamera& calibration() const { return calibration_; }
  int64_t oldest_timestamp_ns() const { return frames_.front().timestamp_ns; }
  /// The newest frame's. The window must not be empty.
  const Rigid3& world_from_body() const { return frames_.back().world_from_body; }
  /// Of all its frames as the last Optimize() has them, the oldest first.
  Trajectory Poses() const;
  bool newest_is_keyframe() const { return frames_.back().is_keyframe; }
  /// Landmarks that have a depth.
  std::size_t CountLandmarks() const;
  std::vector<MapPoint> MapPoints() const;

  /// An observation of a frame that is not in the window yet, with the landmark it belongs to.
  struct Correspondence {
    std::size_t observation = 0;  ///< Index into TrackedFrame::observations.
    PnpObservation pnp;
  };
  /// Those observations of `frame` whose landmarks have a depth, and how well they know it where
  /// keypoints have a standard deviation of `noise` on the normalised plane.
  std::vector<Correspondence> Correspond(const TrackedFrame& frame, double noise) const;

  /// Adds the newest frame and decides whether it is a key frame. `verdicts`, one an observation
  /// where known: an outlier starts a new landmark instead of spoiling the old one, a wrong right
  /// view is left out.
  void AddFrame(const TrackedFrame& frame, const Rigid3& world_from_body,
                const std::vector<std::optional<PnpVerdict>>& verdicts);
  /// Gives a depth to landmarks that have none and can be triangulated, from one frame's stereo or
  /// from several frames.
  void Triangulate();
  /// Bundle adjustment. Throws nothing: where the solver fails the window stays as it was, and the
  /// answer is false.
  bool Optimize();
  struct Motion {
    Rigid3 keyframe_from_body;
    PoseCovariance covariance;
  };
  /// The newest frame's pose in the newest key frame before it, as the last Optimize() has it, and
  /// how well it knows it. Observations are taken to be as good as they fit: the covariance is
  /// scaled by the mean square of the residuals. Nothing where the newest frame is the only one, or
  /// where the window does not settle it.
  std::optional<Motion> MotionSinceKeyframe();
  /// Drops landmarks that fit badly or came to lie behind a camera that sees them; those seen in
  /// the newest frame start again from it.
  void RemoveOutliers();
  /// Makes room for the next frame: where the window is full, the newest but one leaves if it is
  /// no key frame (and tracking has not just broken down), else the oldest. What the oldest frame
  /// and the landmarks anchored in it say of the other poses stays as a prior.
  void Slide();

  /// From here on the readings of an inertial unit, whose frame is the body's, count, too. `start`
  /// is of the window's world; its covariance is taken for four times as large, since the readings
  /// between the window's frames may be in it already. `readings` must outlive the window; they
  /// have to reach to each frame before that is added. Where the start knows of a time offset, it
  /// is estimated further, from that of the readings on: they should follow it (time_offset_s()).
  /// The window must not be empty.
  void StartInertia(const InertialStart& start, const ImuReadings& readings);
  /// The readings count no more; what they said of poses that left the window stays.
  void StopInertia();
  bool has_inertia() const { return readings_ != nullptr; }
  /// The body stood still since the frame before the newest, as the views show and, once they
  /// count, the readings; the factor's weight does not matter. It counts from StartInertia() on,
  /// where that is from rest.
  void HoldStill(const StillFactor& still);
  /// The newest frame's, and gravity, with an inertial unit.
  InertialState state() const;
  Eigen::Vector3d gravity_in_world() const { return gravity_.InWorld(); }
  /// That of ImuReadings, seconds; nothing where it is not estimated.
  const std::optional<double>& time_offset_s() const { return time_offset_s_; }
  /// One standard deviation, seconds, after MotionSinceKeyframe(); 0 where it is not estimated.
  double time_offset_sigma_s() const { return time_offset_sigma_s_; }
  /// How well velocity, biases (VelocityAndBias) and gravity's direction (radians, two) are known,
  /// after MotionSinceKeyframe().
  using InertialCovariance = Eigen::Matrix<double, 11, 11>;
  const std::optional<InertialCovariance>& inertial_covariance() const {
    return inertial_covariance_;
  }
  /// How far the newest frame's readings contradict the rest: mean squares of the residuals from
  /// the frame before, in shares of their variances: of rotation and the gyroscope's bias, and of
  /// position, velocity and the accelerometer's bias. Zeros without.
  struct InertialMisfit {
    double gyroscope = 0.0;
    double accelerometer = 0.0;
  };
  InertialMisfit Misfit() const;
  struct Prediction {
    InertialState state;
    PoseCovariance covariance;  ///< Of the motion since the newest frame, in the body's axes.
  };
  /// Where the readings lead from the newest frame; nothing without a unit and where its readings
  /// have a gap.
  std::optional<Prediction> Predict(int64_t timestamp_ns) const;

 private:
  struct Frame {
    int64_t id = 0;
    int64_t timestamp_ns = 0;
    Rigid3 world_from_body;
    bool is_keyframe = false;
    bool lost_tracks = false;  // so few tracks came through that the frame before matters
    // With an inertial unit; what was measured since the frame before is absent for the first one.
    VelocityAndBias motion = {};
    std::unique_ptr<InertialFactor> measured = nullptr;
    std::optional<StillFactor> still = std::nullopt;  // since the frame before
  };
  struct LandmarkView {
    int64_t frame_id = 0;
    Eigen::Vector2d left = Eigen::Vector2d::Zero();  // normalised plane
    std::optional<Eigen::Vector2d> right;
  };
  struct Landmark {
    int64_t track_id = 0;
    std::vector<LandmarkView> views;  // in order of frames; the first is the anchor
    /// Estimate in the anchor's left view: u, v on the normalised plane, inverse depth (1/m).
    std::optional<Eigen::Vector3d> point;
    int observations = 1;  // dropped views included
  };
  using Landmarks = std::map<int64_t, Landmark>;
  struct Workspace;

  std::size_t FrameIndex(int64_t frame_id) const;
  const Frame& FrameOf(const LandmarkView& view) const {
    return frames_[FrameIndex(view.frame_id)];
  }
  /// Calls visit(cam_from_anchor_cam, observed) for every view, left and right, of a landmark.
  template <typename Visitor>
  void ForEachView(const Landmark& landmark, Visitor visit) const;
  /// Without its uncertainty.
  AnchoredPoint ToAnchoredPoint(const Landmark& landmark) const;
  double InverseDepthSigma(const Landmark& landmark, double noise) const;
  void DecideKeyframe(std::size_t new_tracks);
  struct Overlap {
    int landmarks = 0;  ///< That both frames see.
    /// How far they have moved, on the normalised plane, once the rig's turn is taken out, which
    /// tells nothing of depths.
    double mean_parallax = 0.0;
  };
  Overlap OverlapOf(const Frame& before, const Frame& now) const;
  /// The point in the first view (as Landmark::point), where triangulation succeeds.
  std::optional<Eigen::Vector3d> TriangulateViews(const std::vector<LandmarkView>& views) const;
  std::optional<double> MeanReprojectionError(const Landmark& landmark) const;
  /// Sets the workspace's problem to one of all frames, without points and prior.
  void StartProblem();
  void AddPriorToProblem();
  void AddInertiaToProblem();
  static bool IsAdjusted(const Landmark& landmark);
  void AddToProblem(const Landmark& landmark);
  /// Asks the equations linearised last, those of the right camera among them, how it sees, and
  /// decides whether that is to be made up for.
  void LearnCalibration(double variance_scale);
  /// Asks the views of the problem that was solved whether the right camera is turned.
  void WeighBend(const WindowSolverLimits& limits);
  /// Takes over what came out of bundle adjustment.
  void TakeOver(const WindowProblem& problem);
  /// Puts into the prior what the landmarks say that are anchored in the oldest frame and no longer
  /// tracked, and removes them. Those that are tracked on keep their other views and so must not
  /// enter it: their views would count twice (Leutenegger et al. 2015, section 3.4). With an
  /// inertial unit, of whose readings all stay, they are cut in two (LeaveAllButNewest).
  void MarginalizeOldest();
  bool BeginsWithOldest(const Landmark& landmark) const;
  bool LeavesWithOldest(const Landmark& landmark) const;
  /// Gives the problem a landmark that is tracked on with all views but the newest, which go on as
  /// one of their own. Dropped one by one with their frames, the views of long tracks would be
  /// outvoted by readings: biases would stay what the first seconds made of them.
  void LeaveAllButNewest(Landmark& landmark);
  /// As Landmark::point of a landmark with that anchor; nothing behind its camera.
  std::optional<Eigen::Vector3d> PointIn(const LandmarkView& anchor,
                                         const Eigen::Vector3d& point_in_world) const;
  void AddProblemTo(Marginalizer& marginalizer);
  /// How far the window is from there.
  Eigen::VectorXd Delta(const PosePrior& linearization) const;
  std::unique_ptr<InertialFactor> FactorOf(const Preintegration& measured) const;
  /// What was measured between the oldest frame and the next one.
  void AddInertiaTo(Marginalizer& marginalizer) const;
  InertialState StateOfFrame(const Frame& frame) const {
    return StateOf(frame.world_from_body, frame.motion);
  }
  /// Measures from frame to frame, and predicts the velocity of the second one.
  void Measure(const Frame& first, Frame& second) const;
  /// Whether it errs by more than the sensors do, and the readings have a better one.
  bool IsTimeOffsetFar(const Preintegration& measured) const;
  void JoinAcross(std::size_t index);
  void DropFrame(std::size_t index);
  Landmarks::iterator Erase(Landmarks::iterator landmark);

  StereoRig calibrated_rig_;
  LearnedRightCamera calibration_;
  SlidingWindowOptions options_;
  std::deque<Frame> frames_;
  Landmarks landmarks_;  // by a number of their own: a track may have had several
  std::unordered_map<int64_t, int64_t> landmark_of_track_;
  std::optional<PosePrior> prior_;
  const ImuReadings* readings_ = nullptr;  // Of the inertial unit once it has started.
  GravityEstimate gravity_;
  std::optional<double> time_offset_s_;
  double time_offset_sigma_s_ = 0.0;
  ViewsNoise views_noise_;
  std::optional<InertialCovariance> inertial_covariance_;
  std::unique_ptr<Workspace> workspace_;
  int64_t next_frame_id_ = 0;
  int64_t next_landmark_id_ = 0;
};

}  // namespace gluevo::vo
