#include <Eigen/Geometry>
#include <array>
#include <cstddef>

#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "gluevo/vo/geometry/manifold.h"
#include "sliding_window_workspace.h"

// How the right camera sees, against its calibration.
namespace gluevo::vo {
namespace {

// Views of fewer frames see few distances: what lenses add to them may be anything, of which
// standard deviations know nothing.
constexpr std::size_t kFewestFrames = 5;

}  // namespace

StereoRig SlidingWindow::rig() const {
  StereoRig rig = calibrated_rig_;
  Eigen::Quaterniond& body_from_right = rig.body_from_cam[1].rotation;
  body_from_right =
      (body_from_right * ExpSo3(calibration_.correction.turn).conjugate()).normalized();
  return rig;
}

void SlidingWindow::LearnCalibration(double variance_scale) {
  // By so much may matches to subpixels err all in one direction. Standard deviations are of noise
  // and know nothing of that: on rendered images, whose calibration is exact, views ask for 0.01 px
  // with a standard deviation of 0.002, which makes paths 0.1 % too long.
  constexpr double kMatchingBias = FromReferencePx(0.015);
  constexpr double kSigmas = 3.0;
  // What is made up for stays so until it is surely too little to be told from none.
  constexpr double kStays = 0.5;
  const Eigen::Array3d variance = variance_scale * workspace_->equations.VarianceOfTurn().array();
  calibration_.turn_sigma = variance.sqrt();
  calibration_.turn = calibration_.correction.turn + workspace_->equations.StepOfTurn();
  const Eigen::Array3d bound = (calibration_.is_off ? kStays : 1.0) * kSigmas *
                               (variance + kMatchingBias * kMatchingBias).sqrt();
  calibration_.is_known = calibration_.is_known || frames_.size() >= kFewestFrames;
  calibration_.is_off = calibration_.is_known && (calibration_.turn.array().abs() > bound).any();
}

void SlidingWindow::WeighBend(const WindowSolverLimits& limits) {
  // A wrong one is not to be followed for long; later ones are of windows without a frame in
  // common.
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
