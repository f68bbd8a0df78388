#include "window_ceres.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "pose_manifold.h"
#include "pose_prior_factor.h"
#include "reprojection_factors.h"

namespace gluevo::vo {
namespace {

// What the calibration says of the right camera's orientation: that it is right within `sigma`.
class CalibrationPrior final : public ceres::SizedCostFunction<3, 3> {
 public:
  explicit CalibrationPrior(double sigma) : sigma_(sigma) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    Eigen::Map<Eigen::Vector3d> residual(residuals);
    residual = Eigen::Map<const Eigen::Vector3d>(parameters[0]) / sigma_;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix3d> jacobian(jacobians[0]);
      jacobian = Eigen::Matrix3d::Identity() / sigma_;
    }
    return true;
  }

 private:
  double sigma_;
};

// The window as a problem of Ceres: what is built here is solved once and taken over, or dropped.
class Adjustment {
 public:
  explicit Adjustment(WindowProblem& window);
  bool Solve(const WindowSolverLimits& limits);
  void TakeOver();

 private:
  static constexpr int kPose = PoseManifold::kAmbientSize;

  static ceres::Problem::Options ProblemOptions();
  double* Pose(int frame) { return state_.data() + kPose * frame; }
  double* Turn(int camera) {
    return state_.data() + kPose * window_.world_from_body.size() + 3 * camera;
  }
  void AddPoses();
  void AddTurns();
  void AddPrior();
  void AddPoint(const WindowProblem::Point& point, double* position);

  WindowProblem& window_;
  PoseManifold manifold_;
  ceres::HuberLoss loss_;
  // Ceres orders blocks by their addresses. In one array each, they come in order, and sums repeat
  // to the last bit: the frames' poses, then the turns of both cameras; the points.
  std::vector<double> state_;
  std::vector<Eigen::Vector3d> points_;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering_ =
      std::make_shared<ceres::ParameterBlockOrdering>();
  ceres::Problem problem_{ProblemOptions()};
};

ceres::Problem::Options Adjustment::ProblemOptions() {
  ceres::Problem::Options options;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

Adjustment::Adjustment(WindowProblem& window)
    : window_(window),
      loss_(window.huber),
      state_(kPose * window.world_from_body.size() + 2 * 3, 0.0) {
  AddPoses();
  AddTurns();
  AddPrior();
  points_.reserve(window.points.size());
  for (const WindowProblem::Point& point : window.points) {
    double* const position = points_.emplace_back(point.position).data();
    AddPoint(point, position);
    ordering_->AddElementToGroup(position, 0);  // Points are eliminated first.
  }
}

void Adjustment::AddPoses() {
  for (int i = 0; i < static_cast<int>(window_.world_from_body.size()); ++i) {
    const PoseParameters pose = ToParameters(window_.world_from_body[static_cast<std::size_t>(i)]);
    std::copy(pose.begin(), pose.end(), Pose(i));
    problem_.AddParameterBlock(Pose(i), kPose, &manifold_);
    ordering_->AddElementToGroup(Pose(i), 1);
  }
  problem_.SetParameterBlockConstant(Pose(0));
}

// The left camera is the rig's reference; the right one's orientation may be refined.
void Adjustment::AddTurns() {
  std::copy_n(window_.turn.data(), 3, Turn(1));
  for (const int camera : {0, 1}) {
    problem_.AddParameterBlock(Turn(camera), 3);
    ordering_->AddElementToGroup(Turn(camera), 1);
  }
  problem_.SetParameterBlockConstant(Turn(0));
  if (window_.turn_sigma > 0.0) {
    problem_.AddResidualBlock(new CalibrationPrior(window_.turn_sigma), nullptr, Turn(1));
  } else {
    problem_.SetParameterBlockConstant(Turn(1));
  }
}

void Adjustment::AddPrior() {
  if (window_.prior == nullptr) {
    return;
  }
  std::vector<double*> blocks;
  blocks.reserve(window_.prior_frames.size() + 1);
  for (const int frame : window_.prior_frames) {
    blocks.push_back(Pose(frame));
  }
  blocks.push_back(Turn(1));
  problem_.AddResidualBlock(new PosePriorFactor(*window_.prior), nullptr, blocks);
}

void Adjustment::AddPoint(const WindowProblem::Point& point, double* position) {
  const auto& body_from_cam = window_.body_from_cam;
  const Rigid3 right_from_left = body_from_cam[1].Inverse() * body_from_cam[0];
  for (int v = point.first_view; v < point.end_view; ++v) {
    const WindowProblem::View& view = window_.views[static_cast<std::size_t>(v)];
    if (view.frame == point.anchor) {
      problem_.AddResidualBlock(
          new SameFrameReprojection(view.camera == 0 ? Rigid3{} : right_from_left, view.seen,
                                    window_.weight, window_.bend),
          &loss_, position, Turn(view.camera));
    } else {
      problem_.AddResidualBlock(
          new OtherFrameReprojection(body_from_cam[0],
                                     body_from_cam[static_cast<std::size_t>(view.camera)],
                                     view.seen, window_.weight, window_.bend),
          &loss_, Pose(point.anchor), Pose(view.frame), position, Turn(view.camera));
    }
  }
}

bool Adjustment::Solve(const WindowSolverLimits& limits) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering_;
  options.max_num_iterations = limits.max_iterations;
  options.function_tolerance = limits.least_decrease;
  // More threads would sum the cost in the order in which they finish, which changes from run to
  // run.
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem_, &summary);
  return summary.IsSolutionUsable() && std::isfinite(summary.final_cost);
}

void Adjustment::TakeOver() {
  for (int i = 1; i < static_cast<int>(window_.world_from_body.size()); ++i) {
    window_.world_from_body[static_cast<std::size_t>(i)] = ToRigid3(Pose(i));
  }
  window_.turn = Eigen::Map<const Eigen::Vector3d>(Turn(1));
  for (std::size_t i = 0; i < points_.size(); ++i) {
    window_.points[i].position = points_[i];
  }
}

}  // namespace

bool SolveByCeres(WindowProblem& problem, const WindowSolverLimits& limits) {
  Adjustment adjustment(problem);
  if (!adjustment.Solve(limits)) {
    return false;
  }
  adjustment.TakeOver();
  return true;
}

}  // namespace gluevo::vo
