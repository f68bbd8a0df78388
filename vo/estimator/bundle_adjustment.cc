#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <vector>

#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "pose_manifold.h"
#include "pose_prior_factor.h"
#include "reprojection_factors.h"

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

// The window as a problem of Ceres: what is built here is solved once and taken over, or dropped.
class SlidingWindow::Adjustment {
 public:
  explicit Adjustment(SlidingWindow& window);
  bool Solve();
  void TakeOver();

 private:
  static constexpr int kPose = PoseManifold::kAmbientSize;

  static ceres::Problem::Options ProblemOptions();
  double* Pose(std::size_t frame) { return state_.data() + kPose * frame; }
  double* PoseOf(const LandmarkView& view) { return Pose(window_.FrameIndex(view.frame_id)); }
  double* Turn(int camera) { return Pose(window_.frames_.size()) + 3 * camera; }
  void AddPoses();
  void AddTurns();
  void AddPrior();
  void AddLandmarks();
  void AddLandmark(const Landmark& landmark, double* point);

  SlidingWindow& window_;
  double weight_;
  Rigid3 right_from_left_;
  PoseManifold manifold_;
  ceres::HuberLoss loss_;
  // Ceres orders blocks by their addresses. In one array each, they come in order, and sums repeat
  // to the last bit: the frames' poses, then the turns of both cameras; the adjusted landmarks.
  std::vector<double> state_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<Landmark*> adjusted_;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering_ =
      std::make_shared<ceres::ParameterBlockOrdering>();
  ceres::Problem problem_{ProblemOptions()};
};

ceres::Problem::Options SlidingWindow::Adjustment::ProblemOptions() {
  ceres::Problem::Options options;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

SlidingWindow::Adjustment::Adjustment(SlidingWindow& window)
    : window_(window),
      weight_(1.0 / FromReferencePx(window.options_.noise_px)),
      right_from_left_(window.rig_.right_from_left()),
      loss_(window.options_.huber),
      state_(kPose * window.frames_.size() + 2 * 3, 0.0) {
  AddPoses();
  AddTurns();
  AddPrior();
  AddLandmarks();
}

void SlidingWindow::Adjustment::AddPoses() {
  for (std::size_t i = 0; i < window_.frames_.size(); ++i) {
    const PoseParameters pose = ToParameters(window_.frames_[i].world_from_body);
    std::copy(pose.begin(), pose.end(), Pose(i));
    problem_.AddParameterBlock(Pose(i), kPose, &manifold_);
    ordering_->AddElementToGroup(Pose(i), 1);
  }
  problem_.SetParameterBlockConstant(Pose(0));
}

// The left camera is the rig's reference; the right one's orientation may be refined.
void SlidingWindow::Adjustment::AddTurns() {
  for (const int camera : {0, 1}) {
    problem_.AddParameterBlock(Turn(camera), 3);
    ordering_->AddElementToGroup(Turn(camera), 1);
  }
  problem_.SetParameterBlockConstant(Turn(0));
  const double sigma = 1e-3 * window_.options_.right_turn_sigma_mrad;
  if (sigma > 0.0) {
    const Eigen::Quaterniond turn_so_far =
        window_.rig_.body_from_cam[1].rotation.conjugate() * window_.calibrated_body_from_right_;
    problem_.AddResidualBlock(new CalibrationPrior(LogSo3(turn_so_far), sigma), nullptr, Turn(1));
  } else {
    problem_.SetParameterBlockConstant(Turn(1));
  }
}

void SlidingWindow::Adjustment::AddPrior() {
  if (!window_.prior_) {
    return;
  }
  std::vector<double*> blocks;
  for (const int64_t frame_id : window_.prior_->frame_ids) {
    blocks.push_back(Pose(window_.FrameIndex(frame_id)));
  }
  blocks.push_back(Turn(1));
  problem_.AddResidualBlock(
      new PosePriorFactor(*window_.prior_, window_.rig_.body_from_cam[1].rotation), nullptr,
      blocks);
}

// The landmarks are eliminated first (Schur complement).
void SlidingWindow::Adjustment::AddLandmarks() {
  points_.reserve(window_.landmarks_.size());
  for (auto& [id, landmark] : window_.landmarks_) {
    // A landmark of a single frame tells nothing about poses, and its stereo gave its depth.
    if (!landmark.point || landmark.views.size() < 2) {
      continue;
    }
    adjusted_.push_back(&landmark);
    double* const point = points_.emplace_back(*landmark.point).data();
    AddLandmark(landmark, point);
    ordering_->AddElementToGroup(point, 0);
  }
}

void SlidingWindow::Adjustment::AddLandmark(const Landmark& landmark, double* point) {
  const auto& body_from_cam = window_.rig_.body_from_cam;
  const LandmarkView& anchor = landmark.views.front();
  problem_.AddResidualBlock(new SameFrameReprojection({}, anchor.left, weight_), &loss_, point,
                            Turn(0));
  if (anchor.right) {
    problem_.AddResidualBlock(new SameFrameReprojection(right_from_left_, *anchor.right, weight_),
                              &loss_, point, Turn(1));
  }
  for (auto view = std::next(landmark.views.begin()); view != landmark.views.end(); ++view) {
    problem_.AddResidualBlock(
        new OtherFrameReprojection(body_from_cam[0], body_from_cam[0], view->left, weight_), &loss_,
        PoseOf(anchor), PoseOf(*view), point, Turn(0));
    if (view->right) {
      problem_.AddResidualBlock(
          new OtherFrameReprojection(body_from_cam[0], body_from_cam[1], *view->right, weight_),
          &loss_, PoseOf(anchor), PoseOf(*view), point, Turn(1));
    }
  }
}

bool SlidingWindow::Adjustment::Solve() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.trust_region_strategy_type = ceres::DOGLEG;
  options.linear_solver_ordering = ordering_;
  options.max_num_iterations = window_.options_.max_iterations;
  // More threads would sum the cost in the order in which they finish, which changes from run to
  // run.
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem_, &summary);
  return summary.IsSolutionUsable() && std::isfinite(summary.final_cost);
}

void SlidingWindow::Adjustment::TakeOver() {
  for (std::size_t i = 1; i < window_.frames_.size(); ++i) {
    window_.frames_[i].world_from_body = ToRigid3(Pose(i));
  }
  Eigen::Quaterniond& body_from_right = window_.rig_.body_from_cam[1].rotation;
  const Eigen::Map<const Eigen::Vector3d> turn(Turn(1));
  body_from_right = (body_from_right * ExpSo3(turn).conjugate()).normalized();
  for (std::size_t i = 0; i < adjusted_.size(); ++i) {
    adjusted_[i]->point = points_[i];
  }
}

bool SlidingWindow::Optimize() {
  if (frames_.size() < 2) {
    return true;
  }
  Adjustment adjustment(*this);
  if (!adjustment.Solve()) {
    return false;
  }
  adjustment.TakeOver();
  return true;
}

}  // namespace gluevo::vo
