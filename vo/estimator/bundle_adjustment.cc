#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "gluevo/vo/estimator/reprojection_factors.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "gluevo/vo/geometry/pose_manifold.h"

namespace gluevo::vo {
namespace {

// What the calibration says of the right camera's orientation: that it is right within `sigma`.
class CalibrationPrior final : public ceres::SizedCostFunction<3, 3> {
 public:
  // `turn_so_far`: rotation vector from the calibrated to the present right camera, radians.
  CalibrationPrior(const Eigen::Vector3d& turn_so_far, double sigma)
      : turn_so_far_(turn_so_far), sigma_(sigma) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    Eigen::Map<Eigen::Vector3d> residual(residuals);
    residual = (turn_so_far_ + Eigen::Map<const Eigen::Vector3d>(parameters[0])) / sigma_;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix3d> jacobian(jacobians[0]);
      jacobian = Eigen::Matrix3d::Identity() / sigma_;
    }
    return true;
  }

 private:
  Eigen::Vector3d turn_so_far_;
  double sigma_;
};

}  // namespace

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

  // The left camera is the rig's reference; the right one's orientation may be refined.
  std::array<Eigen::Vector3d, 2> turns = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  problem.AddParameterBlock(turns[0].data(), 3);
  problem.AddParameterBlock(turns[1].data(), 3);
  problem.SetParameterBlockConstant(turns[0].data());
  if (options_.right_turn_sigma > 0.0) {
    const Eigen::Quaterniond turn_so_far =
        rig_.body_from_cam[1].rotation.conjugate() * calibrated_body_from_right_;
    problem.AddResidualBlock(new CalibrationPrior(LogSo3(turn_so_far), options_.right_turn_sigma),
                             nullptr, turns[1].data());
  } else {
    problem.SetParameterBlockConstant(turns[1].data());
  }

  if (prior_) {
    std::vector<double*> blocks;
    for (const int64_t frame_id : prior_->frame_ids) {
      blocks.push_back(poses[FrameIndex(frame_id)].data());
    }
    blocks.push_back(turns[1].data());
    problem.AddResidualBlock(new PosePriorFactor(*prior_, rig_.body_from_cam[1].rotation), nullptr,
                             blocks);
  }

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
    problem.AddResidualBlock(new SameFrameReprojection({}, anchor.left, weight), &loss, point,
                             turns[0].data());
    if (anchor.right) {
      problem.AddResidualBlock(new SameFrameReprojection(right_from_left, *anchor.right, weight),
                               &loss, point, turns[1].data());
    }
    for (auto view = std::next(landmark.views.begin()); view != landmark.views.end(); ++view) {
      double* pose = poses[FrameIndex(view->frame_id)].data();
      problem.AddResidualBlock(
          new OtherFrameReprojection(rig_.body_from_cam[0], rig_.body_from_cam[0], view->left,
                                     weight),
          &loss, anchor_pose, pose, point, turns[0].data());
      if (view->right) {
        problem.AddResidualBlock(
            new OtherFrameReprojection(rig_.body_from_cam[0], rig_.body_from_cam[1], *view->right,
                                       weight),
            &loss, anchor_pose, pose, point, turns[1].data());
      }
    }
    ordering->AddElementToGroup(point, 0);
  }
  ordering->AddElementToGroup(turns[0].data(), 1);
  ordering->AddElementToGroup(turns[1].data(), 1);
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
  rig_.body_from_cam[1].rotation =
      (rig_.body_from_cam[1].rotation * ExpSo3(turns[1]).conjugate()).normalized();
  for (std::size_t i = 0; i < adjusted.size(); ++i) {
    adjusted[i]->point = points[i];
  }
  return true;
}

}  // namespace gluevo::vo
