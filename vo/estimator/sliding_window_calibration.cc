#include <Eigen/Geometry>
#include <array>
#include <cstddef>

#include "gluevo/vo/estimator/sliding_window.h"
#include "gluevo/vo/geometry/manifold.h"
#include "sliding_window_workspace.h"

// How the right camera sees, against its calibration.
namespace gluevo::vo {

StereoRig SlidingWindow::rig() const {
  StereoRig rig = calibrated_rig_;
  Eigen::Quaterniond& body_from_right = rig.body_from_cam[1].rotation;
  body_from_right =
      (body_from_right * ExpSo3(calibration_.correction.turn).conjugate()).normalized();
  return rig;
}

void SlidingWindow::WeighBend(const WindowSolverLimits& limits) {
  // So few, so that a wrong one is not followed for long; then windows without a frame in common.
  constexpr std::size_t kFewestFrames = 5;
  const WindowProblem& problem = workspace_->problem;
  if (!(problem.turn_sigma > 0.0) || calibration_.bend.is_complete() ||
      frames_.size() < kFewestFrames || --calibration_.frames_to_weigh > 0) {
    return;
  }
  calibration_.frames_to_weigh = options_.size;
  std::array<double, BendEvidence::kBends.size()> costs = {};
  for (std::size_t i = 0; i < costs.size(); ++i) {
    WindowProblem& trial = workspace_->trial;
    trial = problem;
    trial.bend = BendEvidence::kBends[i];
    if (!workspace_->solver.Solve(trial, limits)) {
      return;
    }
    costs[i] = workspace_->solver.cost();
  }
  calibration_.bend.Add(costs);
  calibration_.correction.bend = calibration_.bend.Bend();
}

}  // namespace gluevo::vo
