#pragma once

#include "window_equations.h"
#include "window_problem.h"

namespace gluevo::vo {

/// Solves a window by the method of Levenberg and Marquardt, with the rules for the damping of
/// Madsen, Nielsen and Tingleff (2004, section 3.2) as Ceres has them. Allocates nothing for a
/// problem that is no larger than those before.
class WindowSolver {
 public:
  /// False where the cost is not finite; the problem is as before then. The same sums in the same
  /// order every time.
  bool Solve(WindowProblem& problem, const WindowSolverLimits& limits);
  /// Of the last problem.
  int iterations() const { return iterations_; }
  /// Half the sum of squares that is left (WindowEquations::Cost).
  double cost() const { return cost_; }

 private:
  void MoveBy(const WindowState& from, WindowState& to) const;

  WindowEquations equations_;
  WindowState state_, candidate_;
  int iterations_ = 0;
  double cost_ = 0.0;
};

}  // namespace gluevo::vo
