#pragma once

#include <Eigen/Core>
#include <vector>

#include "gluevo/vo/estimator/sliding_window.h"
#include "window_equations.h"
#include "window_points.h"
#include "window_problem.h"
#include "window_solver.h"

namespace gluevo::vo {

/// What bundle adjustment and marginalisation work in, kept so that they ask for no memory once it
/// has grown to what they need.
struct SlidingWindow::Workspace {
  WindowProblem problem;
  WindowSolver solver;
  WindowEquations equations;  // At what the solver found.
  WindowState state;

  WindowProblem trial;  // Of another calibration.

  // Marginalisation alone.
  std::vector<Eigen::Vector3d> positions;
  WindowGeometry at_present, at_first_estimates;
  WindowPoints points;
  WindowSystem system;
};

}  // namespace gluevo::vo
