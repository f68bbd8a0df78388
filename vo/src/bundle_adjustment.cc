#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>

#include "gluevo/vo/pose_manifold.h"
#include "gluevo/vo/reprojection_factors.h"
#include "gluevo/vo/sliding_window.h"

namespace gluevo::vo {

bool SlidingWindow::Optimize() {
  if (frames_.size() < 2) {
    return true;
  }
  const double weight = 1.0 / options_.noise;
  const Rigid3 right_from_left = rig_.right_from_left();
  PoseManifold manifold;
  ceres::HuberLoss loss(options_.huber);
  ceres::Problem::Options problem_options;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);

  std::vector<PoseParameters> poses;
  poses.reserve(frames_.size());
  for (const Frame& frame : frames_) {
    poses.push_back(ToParameters(frame.world_from_body));
    problem.AddParameterBlock(poses.back().data(), PoseManifold::kAmbientSize, &manifold);
  }
  problem.SetParameterBlockConstant(poses.front().data());

  // The landmarks are eliminated first (Schur complement). Ceres orders blocks by their addresses:
  // in one array they come in the landmarks' order, and sums repeat to the last bit.
  std::vector<Eigen::Vector3d> points;
  points.reserve(landmarks_.size());
  std::vector<Landmark*> adjusted;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (auto& [id, landmark] : landmarks_) {
    // A landmark of a single frame tells nothing about poses, and its stereo gave its depth.
    if (!landmark.point || landmark.views.size() < 2) {
      continue;
    }
    adjusted.push_back(&landmark);
    double* point = points.emplace_back(*landmark.point).data();
    const LandmarkView& anchor = landmark.views.front();
    double* anchor_pose = poses[FrameIndex(anchor.frame_id)].data();
    problem.AddResidualBlock(new SameFrameReprojection({}, anchor.left, weight), &loss, point);
    if (anchor.right) {
      problem.AddResidualBlock(new SameFrameReprojection(right_from_left, *anchor.right, weight),
                               &loss, point);
    }
    for (auto view = std::next(landmark.views.begin()); view != landmark.views.end(); ++view) {
      double* pose = poses[FrameIndex(view->frame_id)].data();
      problem.AddResidualBlock(new OtherFrameReprojection(rig_.body_from_cam[0],
                                                          rig_.body_from_cam[0], view->left, weight),
                               &loss, anchor_pose, pose, point);
      if (view->right) {
        problem.AddResidualBlock(
            new OtherFrameReprojection(rig_.body_from_cam[0], rig_.body_from_cam[1], *view->right,
                                       weight),
            &loss, anchor_pose, pose, point);
      }
    }
    ordering->AddElementToGroup(point, 0);
  }
  for (PoseParameters& pose : poses) {
    ordering->AddElementToGroup(pose.data(), 1);
  }

  ceres::Solver::Options solver_options;
  solver_options.linear_solver_type = ceres::DENSE_SCHUR;
  solver_options.trust_region_strategy_type = ceres::DOGLEG;
  solver_options.linear_solver_ordering = ordering;
  solver_options.max_num_iterations = options_.max_iterations;
  // More threads would sum the cost in the order in which they finish, which changes from run to
  // run.
  solver_options.num_threads = 1;
  solver_options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options, &problem, &summary);
  if (!summary.IsSolutionUsable() || !std::isfinite(summary.final_cost)) {
    return false;
  }
  for (std::size_t i = 1; i < frames_.size(); ++i) {
    frames_[i].world_from_body = ToRigid3(poses[i].data());
  }
  for (std::size_t i = 0; i < adjusted.size(); ++i) {
    adjusted[i]->point = points[i];
  }
  return true;
}

}  // namespace gluevo::vo
