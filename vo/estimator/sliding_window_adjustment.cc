#include <algorithm>

#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "sliding_window_workspace.h"
#include "window_ceres.h"

// Bundle adjustment: the window as a problem of its own, and what comes out of it taken over.
namespace gluevo::vo {

void SlidingWindow::StartProblem() {
  WindowProblem& problem = workspace_->problem;
  problem.body_from_cam = calibrated_rig_.body_from_cam;
  problem.weight = 1.0 / FromReferencePx(options_.noise_px);
  problem.huber = options_.huber;
  problem.turn = calibration_.correction.turn;
  problem.bend = calibration_.correction.bend;
  problem.turn_sigma = 1e-3 * options_.right_turn_sigma_mrad;
  problem.world_from_body.resize(frames_.size());
  std::transform(frames_.begin(), frames_.end(), problem.world_from_body.begin(),
                 [](const Frame& frame) { return frame.world_from_body; });
  problem.points.clear();
  problem.views.clear();
  problem.prior = nullptr;
  problem.motions.clear();
  problem.measured.clear();
  problem.still.clear();
  problem.time_offset_s.reset();
}

void SlidingWindow::AddPriorToProblem() {
  if (!prior_) {
    return;
  }
  WindowProblem& problem = workspace_->problem;
  problem.prior = &*prior_;
  problem.prior_frames.resize(prior_->frame_ids.size());
  std::transform(prior_->frame_ids.begin(), prior_->frame_ids.end(), problem.prior_frames.begin(),
                 [this](int64_t frame_id) { return static_cast<int>(FrameIndex(frame_id)); });
}

// A landmark of a single frame tells nothing about poses, and its stereo gave its depth. Two views
// of two frames, without a right one, fit every wrong match that lies on its epipolar line at some
// depth; the nearer, the more such a point would have to say: a third view must agree.
bool SlidingWindow::IsAdjusted(const Landmark& landmark) {
  constexpr std::ptrdiff_t kFewestViews = 3;  // Of either camera.
  const auto rights =
      std::count_if(landmark.views.begin(), landmark.views.end(),
                    [](const LandmarkView& view) { return view.right.has_value(); });
  const auto lefts = static_cast<std::ptrdiff_t>(landmark.views.size());
  return landmark.point && lefts > 1 && lefts + rights >= kFewestViews;
}

void SlidingWindow::AddToProblem(const Landmark& landmark) {
  WindowProblem& problem = workspace_->problem;
  WindowProblem::Point point{
      .position = *landmark.point,
      .anchor = static_cast<int>(FrameIndex(landmark.views.front().frame_id)),
      .first_view = static_cast<int>(problem.views.size())};
  for (const LandmarkView& view : landmark.views) {
    const auto frame = static_cast<int>(FrameIndex(view.frame_id));
    problem.views.push_back({frame, 0, view.left});
    if (view.right) {
      problem.views.push_back({frame, 1, *view.right});
    }
  }
  point.end_view = static_cast<int>(problem.views.size());
  problem.points.push_back(point);
}

void SlidingWindow::TakeOver(const WindowProblem& problem) {
  for (std::size_t i = 1; i < frames_.size(); ++i) {
    frames_[i].world_from_body = problem.world_from_body[i];
  }
  for (std::size_t i = 0; i < problem.motions.size(); ++i) {
    frames_[i].motion = problem.motions[i];
  }
  gravity_.turn = problem.gravity.turn;
  time_offset_s_ = problem.time_offset_s;
  calibration_.correction.turn = problem.turn;
  auto point = problem.points.begin();
  for (auto& [id, landmark] : landmarks_) {
    if (IsAdjusted(landmark)) {
      landmark.point = (point++)->position;
    }
  }
}

bool SlidingWindow::Optimize() {
  if (frames_.size() < 2) {
    return true;
  }
  StartProblem();
  AddPriorToProblem();
  AddInertiaToProblem();
  for (const auto& [id, landmark] : landmarks_) {
    if (IsAdjusted(landmark)) {
      AddToProblem(landmark);
    }
  }
  WindowProblem& problem = workspace_->problem;
  if (!calibration_.is_off) {
    problem.turn = Eigen::Vector3d::Zero();
    problem.turn_sigma = 0.0;
  }
  const WindowSolverLimits limits{.max_iterations = options_.max_iterations,
                                  .least_decrease = options_.least_decrease};
  // What is made up for for the first time is first told to be a turn or a shift.
  if (!calibration_.bend.has_begun()) {
    WeighBend(limits);
    problem.bend = calibration_.correction.bend;
  }
  const bool is_solved = options_.solver == "ceres" ? SolveByCeres(problem, limits)
                                                    : workspace_->solver.Solve(problem, limits);
  if (is_solved) {
    TakeOver(problem);
    WeighBend(limits);
  }
  return is_solved;
}

}  // namespace gluevo::vo
