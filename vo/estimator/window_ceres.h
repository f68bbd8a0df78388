#pragma once

#include "window_problem.h"

namespace gluevo::vo {

/// The same as WindowSolver by Ceres: slower, and what that is tested against. False where Ceres
/// finds no usable solution; the problem is as before then.
bool SolveByCeres(WindowProblem& problem, const WindowSolverLimits& limits);

}  // namespace gluevo::vo
