#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/estimator/pose_prior.h"

namespace gluevo::vo {

/// The window's bundle adjustment as plain data, the same for every solver: the poses of frames,
/// the turn of the right camera, and points that the frames see (Qin et al. 2018, section VI).
/// A solver changes `world_from_body` (but for the first, the gauge), `turn` and the points.
///
/// To add a measurement that is not a view, an inertial one between two frames that follow each
/// other, say:
/// - its data become a member here, and what it estimates besides the pose (velocity, biases) a
///   vector with an entry a frame, here and in WindowState;
/// - WindowColumns::kFrame grows to the size of a frame's whole tangent (15), the pose's first: the
///   points' elimination speaks of the first six columns of a frame and stays as it is;
/// - a file of its own, like window_priors.h, has its cost and adds its part of the normal
///   equations to a WindowSystem; WindowEquations calls both where it calls the priors';
///   WindowSolver moves a state by a frame's whole step.
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

  /// Moves a point x of the right camera's frame to x + turn x x, radians: a rotation to first
  /// order, which is all there is to turns of a milliradian.
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  /// What the calibration says: that turn_so_far + turn is zero within this, radians. 0: the turn
  /// is known and stays as it is.
  double turn_sigma = 0.0;
  Eigen::Vector3d turn_so_far = Eigen::Vector3d::Zero();

  const PosePrior* prior = nullptr;  ///< Of the poses and the turn, where there is one.
  std::vector<int> prior_frames;     ///< The frames that it speaks of, in its order.
  /// The turn from the prior's linearisation point to body_from_cam.
  Eigen::Vector3d prior_turn_so_far = Eigen::Vector3d::Zero();
};

/// What a solver changes, as it goes: the parts of WindowProblem of the same names.
struct WindowState {
  std::vector<Rigid3> world_from_body;
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> points;
};

/// When a solver ends. By counts and costs and never by time, so that results repeat.
struct WindowSolverLimits {
  int max_iterations = 8;
  /// An iteration that lowers the cost by less than this share of it is the last.
  double least_decrease = 1e-6;
};

}  // namespace gluevo::vo
