#pragma once

#include <Eigen/Core>
#include <vector>

#include "window_equations.h"
#include "window_problem.h"
#include "window_reprojection.h"

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
  double cost() const { return equations_.cost(); }

 private:
  struct State {
    std::vector<Rigid3> world_from_body;
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
    std::vector<Eigen::Vector3d> points;
  };
  void MoveBy(const State& from, State& to) const;

  WindowGeometry geometry_;
  WindowEquations equations_;
  State state_, candidate_;
  int iterations_ = 0;
};

}  // namespace gluevo::vo
