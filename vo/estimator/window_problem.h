#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/estimator/pose_prior.h"
#include "gluevo/vo/inertial/gravity.h"
#include "gluevo/vo/inertial/inertial_factor.h"
#include "gluevo/vo/inertial/inertial_residual.h"
#include "gluevo/vo/inertial/still_factor.h"

namespace gluevo::vo {

/// The window's bundle adjustment as plain data, the same for every solver: the poses of frames,
/// the turn of the right camera, and points that the frames see (Qin et al. 2018, section VI).
/// A solver changes `world_from_body` (but for the first, the gauge), `turn`, the points, and with
/// an inertial unit `motions`, gravity's turn and the time offset.
///
/// To add a measurement that is not a view: its data become a member here, what it estimates beside
/// the poses a member here and in WindowState, with columns behind those that there are
/// (WindowColumns); a file of its own, like window_inertial.h, has its cost and adds its part of
/// the normal equations to a WindowSystem; WindowEquations calls both; WindowSolver moves a state
/// by the step.
///
/// All points are on the normalised plane; `weight` is one over their standard deviation there, so
/// residuals have no unit. A point is carried homogeneously, as ray + inverse depth * (...), so
/// that it may be far away.
struct WindowProblem {
  struct View {
    int frame = 0;
    int camera = 0;  ///< 0 left, 1 right.
    Eigen::Vector2d seen = Eigen::Vector2d::Zero();
  };
  struct Point {
    /// u, v and inverse depth (1/m) in the anchor's left view.
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    int anchor = 0;      ///< Frame.
    int first_view = 0;  ///< Into `views`; those of one frame follow each other.
    int end_view = 0;
  };

  std::array<Rigid3, 2> body_from_cam;
  std::vector<Rigid3> world_from_body;
  std::vector<Point> points;
  std::vector<View> views;
  double weight = 1.0;
  double huber = 1.0;  ///< Threshold of the loss, in standard deviations.

  /// Of the right camera (StereoCorrection), radians.
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  /// What the calibration says: that the turn is zero within this, radians. 0: it is known and
  /// stays as it is.
  double turn_sigma = 0.0;
  double bend = 1.0;  ///< Of StereoCorrection.

  const PosePrior* prior = nullptr;  ///< Of the poses and the turn, where there is one.
  std::vector<int> prior_frames;     ///< The frames that it speaks of, in its order.

  /// With an inertial unit, whose frame is the body's: an entry a frame. Else empty, as the next.
  std::vector<VelocityAndBias> motions;
  /// What was measured from each frame to the next one: one fewer than frames.
  std::vector<const InertialFactor*> measured;
  /// From `first` to the next frame the body stood still.
  struct Still {
    int first = 0;
    StillFactor factor;
  };
  std::vector<Still> still;
  /// The poses' gauge is a whole pose, so that gravity's direction in the world is to be found.
  GravityEstimate gravity;
  /// That of ImuReadings, seconds; nothing where it is not estimated. What is known of it
  /// beforehand is in the prior.
  std::optional<double> time_offset_s;

  bool has_inertia() const { return !motions.empty(); }
};

/// What a solver changes, as it goes: the parts of WindowProblem of the same names.
struct WindowState {
  std::vector<Rigid3> world_from_body;
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> points;
  std::vector<VelocityAndBias> motions = {};
  Eigen::Vector2d gravity_turn = Eigen::Vector2d::Zero();
  std::optional<double> time_offset_s = std::nullopt;

  void Set(const WindowProblem& problem);
};

/// When a solver ends. By counts and costs and never by time, so that results repeat.
struct WindowSolverLimits {
  int max_iterations = 8;
  /// An iteration that lowers the cost by less than this share of it is the last.
  double least_decrease = 1e-3;
};

}  // namespace gluevo::vo
