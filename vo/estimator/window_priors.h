#pragma once

#include <Eigen/Core>
#include <vector>

#include "window_problem.h"
#include "window_system.h"

namespace gluevo::vo {

/// What is known besides the views: what the calibration says of the turn, and the prior that
/// frames left behind. Allocates only for priors larger than ever before.
class WindowPriors {
 public:
  /// Those of this problem from now on; it must outlive their use.
  void Set(const WindowProblem& problem);
  /// Half the sum of squares.
  double Cost(const WindowState& state);
  /// Adds to the normal equations, by the tangents at this state.
  void AddTo(const WindowState& state, WindowSystem& system);

 private:
  double TurnCost(const WindowState& state) const;
  /// The prior's residual at the state, and how far that is from the linearisation point.
  void SetResidual(const WindowState& state);
  void AddTurnTo(const WindowState& state, WindowSystem& system) const;
  /// The rows of motions and gravity, once by_step_ and gradient_ are set.
  void AddInertiaTo(WindowSystem& system) const;
  /// Likewise the time offset's.
  void AddTimeOffsetTo(WindowSystem& system) const;

  const WindowProblem* problem_ = nullptr;
  Eigen::MatrixXd hessian_;  ///< J^T J at the linearisation point, of no state.
  Eigen::VectorXd delta_, residual_, gradient_;
  /// How a pose's distance from the linearisation point changes with its tangent, a frame each.
  std::vector<Eigen::Matrix<double, 6, 6>> by_step_;
};

}  // namespace gluevo::vo
