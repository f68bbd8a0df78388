#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/core/inertial_estimate.h"
#include "gluevo/vo/core/map_point.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/core/tracked_frame.h"
#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/inertial/clock_watch.h"
#include "gluevo/vo/inertial/imu_readings.h"
#include "gluevo/vo/inertial/inertial_residual.h"
#include "gluevo/vo/inertial/initialisation.h"
#include "gluevo/vo/inertial/still_factor.h"
#include "gluevo/vo/pipeline/inertial_options.h"
#include "gluevo/vo/pipeline/still_views.h"

namespace gluevo::vo {

/// How an inertial unit started.
struct InertialBegin {
  int64_t timestamp_ns = 0;  ///< Of the frame after which it counts.
  bool is_at_rest = false;
  double gravity_sigma = 0.0;  ///< Radians.
};

/// The readings of an inertial unit beside the odometry: waits until poses bear out a start, and
/// watches how well readings and images agree from then on.
class InertialNavigation {
 public:
  /// `noise`: the unit's own, as its calibration says. Throws Error for figures out of range.
  InertialNavigation(const ImuNoise& noise, const InertialOptions& options);

  /// As ImuReadings::Add.
  void Add(std::span<const ImuSample> samples) { readings_.Add(samples); }
  const ImuReadings& readings() const { return readings_; }
  void ForgetBefore(int64_t time_ns);

  /// A frame that was located, while the unit has not started: a start that the frames so far bear
  /// out.
  std::optional<InertialStart> Try(const StampedPose& world_from_body);
  /// How the body turned between two times by the gyroscope alone (begin_from_end), with the bias
  /// of the frames so far; nothing where readings are missing, and where the frames' turns do not
  /// agree with them. Good enough to look for what was seen before, whether the unit has started or
  /// not.
  std::optional<Eigen::Quaterniond> Turn(int64_t begin_ns, int64_t end_ns) const;
  /// What is known of a frame at `timestamp_ns` now that the unit runs: should the frames' poses
  /// be lost, it starts again from there as soon as three new ones are there, if gravity is still
  /// known well enough and their turns agree with the gyroscope's.
  void Keep(int64_t timestamp_ns, const Eigen::Quaterniond& world_from_body,
            const InertialEstimate& estimate);
  /// What was known has turned out wrong.
  void Forget() { kept_.reset(); }
  /// The frames before have nothing to do with those that come: it has to start again.
  void Restart();
  /// Once it has started: whether readings of half a second, with the state of the located frame
  /// before, show rest. Where they do not, views are compared no more.
  bool WatchRest(int64_t now_ns, const InertialState& before,
                 const Eigen::Vector3d& gravity_in_world);
  /// That the body stood still between the located frame before and `frame`, where the views show
  /// no motion. What a motion may be that they do not show is the factor's sigmas'.
  std::optional<StillFactor> Stillness(const TrackedFrame& frame, int64_t before_ns);
  /// Whether it may be at rest from the newest frame on, so that its views are asked for.
  bool WantsViews() const { return is_resting_ && !still_views_.has_begun(); }
  /// The same frame, with what the map has learnt from it, is what later ones are compared with.
  void WatchViews(const TrackedFrame& frame, const std::vector<MapPoint>& points,
                  const Rigid3& left_cam_from_world);
  /// Mean squares of residuals (in shares of their variances) of a frame's readings, once it has
  /// started. Motors that shake the unit make readings worse than its calibration says: noise is
  /// raised until they are as good as it says.
  void Watch(double gyroscope_mean_square, double accelerometer_mean_square);

  /// What is known by now of the time offset, where it is estimated: the readings follow it, and so
  /// does a start after a loss.
  void FollowTimeOffset(double time_offset_s, double sigma_s);

  /// A frame as the images alone show it (ClockWatch::Add), in a map in which the readings have a
  /// say or not.
  void WatchClock(const StampedPose& world_from_body, bool has_inertia);
  const ClockWatch& clock() const { return clock_; }

  /// The first start.
  const std::optional<InertialBegin>& begin() const { return begin_; }
  /// Why it has not started, for messages.
  const std::string& why_waiting() const { return why_waiting_; }
  /// The noise in use over that of the calibration.
  double gyroscope_noise_factor() const { return gyroscope_.factor; }
  double accelerometer_noise_factor() const { return accelerometer_.factor; }

 private:
  /// How much noisier a sensor is than its calibration says.
  struct Sensor {
    double factor = 1.0;
    double mean_square = 0.5;  // Of late.

    bool Watch(double of_frame);
  };

  /// Of the turn between the last two frames.
  void LearnTurn();
  void LearnBias(const Eigen::Vector3d& gyroscope_bias);
  std::optional<InertialStart> TryKept();
  std::optional<InertialStart> TryAtRest();
  std::optional<InertialStart> TryInMotion();
  bool ImagesAreStill() const;
  bool IsRestByReadings(int64_t now_ns, const InertialState& state,
                        const Eigen::Vector3d& gravity_in_world) const;
  /// Of the frames so far some tens, evenly.
  Trajectory Chosen() const;
  void SetNoise();

  ImuNoise noise_;
  InertialOptions options_;
  ImuReadings readings_;
  struct Kept {
    int64_t timestamp_ns = 0;
    Eigen::Vector3d gravity_in_body;
    InertialEstimate estimate;
  };
  std::optional<Kept> kept_;
  std::deque<Eigen::Vector3d> biases_;  // The gyroscope's, of turns of late, rad/s.
  Trajectory frames_;                   // Located ones, of the last seconds.
  int64_t tried_ns_ = 0;
  Sensor gyroscope_, accelerometer_;
  ClockWatch clock_;
  bool is_resting_ = true;  // By the readings up to the newest frame, once it has started.
  StillViews still_views_;
  std::optional<InertialBegin> begin_;
  std::string why_waiting_ = "no frames";
};

}  // namespace gluevo::vo
