#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "window_motions.h"
#include "window_points.h"
#include "window_priors.h"
#include "window_problem.h"
#include "window_reprojection.h"
#include "window_system.h"

namespace gluevo::vo {

/// A problem's cost and normal equations: the parts of points, priors and the inertial unit
/// together. Allocates only for problems larger than ever before.
class WindowEquations {
 public:
  /// Of this problem from now on; it must outlive their use.
  void Set(const WindowProblem& problem);
  /// Half the sum of squares at a state, those of views under Huber's loss.
  double Cost(const WindowState& state);
  void Linearize(const WindowState& state);
  /// Of what was linearised last.
  double cost() const { return system_.cost; }

  /// The step of Levenberg and Marquardt, the diagonal raised by `damping` times itself. False
  /// where the equations have no finite solution.
  bool Solve(double damping);
  /// Of the last solution, in the columns of WindowColumns, ...
  const Eigen::VectorXd& state_step() const { return step_; }
  const WindowColumns& columns() const { return system_.columns; }
  /// ... and of the points.
  const std::vector<Eigen::Vector3d>& point_steps() const { return points_.steps(); }
  /// Half the sum of squares of the views alone, of what was linearised last.
  double views_cost() const { return views_cost_; }
  /// Covariance of two frames' tangents (PoseTangent), the first's first, as what was linearised
  /// last has it where views have the standard deviations that the problem says; a fixed frame's is
  /// zero. Nothing where the equations do not settle them.
  std::optional<Eigen::Matrix<double, 12, 12>> Covariance(int first, int second);
  /// Likewise of a frame's velocity and biases (VelocityAndBias) and of gravity's turn, once
  /// Covariance() has given something.
  using MotionCovariance = Eigen::Matrix<double, 11, 11>;
  std::optional<MotionCovariance> CovarianceOfMotion(int frame);
  /// Likewise of the time offset where it is estimated, s^2, ...
  double VarianceOfTimeOffset();
  /// ... and of the turn's three components, radians^2.
  Eigen::Vector3d VarianceOfTurn();
  /// By how much the turn would move to where the equations want it, the rest with it; likewise.
  Eigen::Vector3d StepOfTurn();
  /// By how much the linearised problem says that the cost falls with the step.
  double predicted_decrease() const { return predicted_decrease_; }

 private:
  /// The equations for columns_ as right sides, once Covariance() has given something.
  void SolveColumns();
  /// Of one column, likewise.
  double VarianceOfColumn(int column);
  /// The damped equations without points, of which step_ is the right side, for step_.
  bool SolveReduced();

  const WindowProblem* problem_ = nullptr;
  WindowGeometry geometry_;
  WindowPoints points_;
  WindowPriors priors_;
  WindowMotions motions_;
  WindowSystem system_;
  Eigen::MatrixXd reduced_;  ///< After Covariance() its Cholesky factor.
  Eigen::VectorXd step_;     ///< After Covariance() the equations' right side, points eliminated.
  Eigen::MatrixXd columns_;  ///< Of the inverse.
  double views_cost_ = 0.0;
  double predicted_decrease_ = 0.0;
};

}  // namespace gluevo::vo
