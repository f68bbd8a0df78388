#include <algorithm>

#include "gluevo/vo/estimator/sliding_window.h"
#include "sliding_window_workspace.h"

// Marginalisation: what leaves the window stays as a prior on what does not.
namespace gluevo::vo {

void SlidingWindow::MarginalizeOldest() {
  PosePrior linearization;
  linearization.turn = prior_ ? prior_->turn : calibration_.correction.turn;
  linearization.frame_ids.reserve(frames_.size());
  linearization.world_from_body.reserve(frames_.size());
  for (const Frame& frame : frames_) {
    const auto in_prior = prior_ ? prior_->Find(frame.id) : std::nullopt;
    linearization.frame_ids.push_back(frame.id);
    linearization.world_from_body.push_back(in_prior ? prior_->world_from_body[*in_prior]
                                                     : frame.world_from_body);
  }
  if (has_inertia()) {
    linearization.motions = {prior_->motions.front(), frames_[1].motion};
    linearization.gravity_turn = prior_->gravity_turn;
    linearization.time_offset_s = prior_->time_offset_s;
  }
  Marginalizer marginalizer(linearization);
  if (prior_) {
    marginalizer.AddPrior(*prior_);
  }
  if (has_inertia()) {
    AddInertiaTo(marginalizer);
  }
  StartProblem();
  for (auto it = landmarks_.begin(); it != landmarks_.end();) {
    if (LeavesWithOldest(it->second)) {
      if (options_.marginalize && IsAdjusted(it->second)) {
        AddToProblem(it->second);
      }
      it = Erase(it);
    } else {
      if (has_inertia() && options_.marginalize && BeginsWithOldest(it->second)) {
        LeaveAllButNewest(it->second);
      }
      ++it;
    }
  }
  AddProblemTo(marginalizer);
  prior_ = marginalizer.Eliminate(frames_.front().id);
}

bool SlidingWindow::BeginsWithOldest(const Landmark& landmark) const {
  return landmark.point && landmark.views.front().frame_id == frames_.front().id;
}

bool SlidingWindow::LeavesWithOldest(const Landmark& landmark) const {
  return BeginsWithOldest(landmark) && landmark.views.back().frame_id != frames_.back().id;
}

void SlidingWindow::LeaveAllButNewest(Landmark& landmark) {
  // So few that nearly all counts in the prior, so many that they hold the newest poses by
  // themselves.
  constexpr std::ptrdiff_t kKept = 3;
  if (static_cast<std::ptrdiff_t>(landmark.views.size()) <= kKept) {
    return;
  }
  const auto first_kept = landmark.views.end() - kKept;
  Landmark left = landmark;
  left.views.erase(left.views.end() - kKept, left.views.end());
  if (!IsAdjusted(left)) {
    return;
  }
  AddToProblem(left);
  const Eigen::Vector3d point_in_world = ToAnchoredPoint(landmark).InWorld();
  landmark.views.erase(landmark.views.begin(), first_kept);
  landmark.point = PointIn(landmark.views.front(), point_in_world);
}

Eigen::VectorXd SlidingWindow::Delta(const PosePrior& linearization) const {
  std::vector<Rigid3> poses;
  std::vector<VelocityAndBias> motions;
  poses.reserve(frames_.size());
  motions.reserve(frames_.size());
  for (const Frame& frame : frames_) {
    poses.push_back(frame.world_from_body);
    motions.push_back(frame.motion);
  }
  return linearization.Delta(poses, calibration_.correction.turn, motions, gravity_.turn,
                             time_offset_s_);
}

// Residuals as they are now, derivatives at the prior's linearisation point (see PosePrior).
void SlidingWindow::AddProblemTo(Marginalizer& marginalizer) {
  Workspace& workspace = *workspace_;
  const WindowProblem& problem = workspace.problem;
  const PosePrior& linearization = marginalizer.linearization();
  workspace.at_present.Set(problem, problem.world_from_body, problem.turn);
  workspace.at_first_estimates.Set(problem, linearization.world_from_body, problem.turn);
  workspace.positions.resize(problem.points.size());
  std::transform(problem.points.begin(), problem.points.end(), workspace.positions.begin(),
                 [](const WindowProblem::Point& point) { return point.position; });
  WindowSystem& system = workspace.system;
  system.Reset({.frames = static_cast<int>(frames_.size()), .has_turn = problem.turn_sigma > 0.0});
  workspace.points.Linearize(problem, workspace.at_present, workspace.at_first_estimates,
                             workspace.positions, system);
  workspace.points.Invert();
  workspace.points.Eliminate(system.hessian, system.gradient);
  marginalizer.Add(system.hessian, system.gradient, Delta(linearization));
}

}  // namespace gluevo::vo
