#include "window_points.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <vector>

#include "window_robust.h"
#include "window_scene.h"

namespace gluevo::vo {
namespace {

struct Reduced {
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
};

/// The same as WindowPoints by dense matrices: what each point cannot explain is the part of its
/// residuals that is orthogonal to its own derivatives (Mourikis and Roumeliotis 2007, eq. 24).
Reduced ByDenseMatrices(const WindowProblem& problem, const WindowGeometry& residuals_at,
                        const WindowGeometry& derivatives_at, const WindowColumns& columns) {
  Reduced reduced{Eigen::MatrixXd::Zero(columns.Count(), columns.Count()),
                  Eigen::VectorXd::Zero(columns.Count())};
  for (const WindowProblem::Point& point : problem.points) {
    const Eigen::Index rows = 2 * (point.end_view - point.first_view);
    Eigen::MatrixXd by_state = Eigen::MatrixXd::Zero(rows, columns.Count());
    Eigen::MatrixXd by_point = Eigen::MatrixXd::Zero(rows, 3);
    Eigen::VectorXd residuals = Eigen::VectorXd::Zero(rows);
    for (int v = point.first_view; v < point.end_view; ++v) {
      const Eigen::Index row = 2 * (v - point.first_view);
      const WindowProblem::View& view = problem.views[static_cast<std::size_t>(v)];
      const ReprojectionColumns at =
          derivatives_at.Linearize(problem, view, point.anchor, point.position);
      const Eigen::Vector2d residual =
          residuals_at.Residual(problem, view, point.anchor, point.position);
      const double root = std::sqrt(Huber(residual.squaredNorm(), problem.huber).weight);
      residuals.segment<2>(row) = root * residual;
      by_point.middleRows<2>(row) = root * at.by_point.transpose();
      if (view.camera == 1 && columns.has_turn) {
        by_state.block<2, 3>(row, columns.Turn()) = root * at.by_turn.transpose();
      }
      if (view.frame != point.anchor) {
        by_state.block<2, 6>(row, columns.Of(point.anchor)) =
            root * at.by_relative.transpose() * derivatives_at.RelativeByAnchor(point.anchor);
        by_state.block<2, 6>(row, columns.Of(view.frame)) =
            root * at.by_relative.transpose() *
            derivatives_at.RelativeByFrame(point.anchor, view.frame);
      }
    }
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(by_point);
    qr.setThreshold(1e-9);
    const Eigen::MatrixXd q = qr.householderQ();
    const Eigen::MatrixXd rest = q.rightCols(rows - qr.rank()).transpose();
    reduced.hessian += (rest * by_state).transpose() * (rest * by_state);
    reduced.gradient += (rest * by_state).transpose() * (rest * residuals);
  }
  return reduced;
}

Reduced ByWindowPoints(const WindowProblem& problem, const WindowGeometry& residuals_at,
                       const WindowGeometry& derivatives_at, const WindowColumns& columns) {
  std::vector<Eigen::Vector3d> positions;
  for (const WindowProblem::Point& point : problem.points) {
    positions.push_back(point.position);
  }
  WindowSystem system;
  system.Reset(columns);
  WindowPoints points;
  points.Linearize(problem, residuals_at, derivatives_at, positions, system);
  points.Invert();
  points.Eliminate(system.hessian, system.gradient);
  return {system.hessian.selfadjointView<Eigen::Lower>(), system.gradient};
}

void ExpectSame(const WindowProblem& problem, const WindowGeometry& residuals_at,
                const WindowGeometry& derivatives_at) {
  for (const bool has_turn : {false, true}) {
    const WindowColumns columns{.frames = testing::kWindowFrames, .has_turn = has_turn};
    const Reduced expected = ByDenseMatrices(problem, residuals_at, derivatives_at, columns);
    const Reduced got = ByWindowPoints(problem, residuals_at, derivatives_at, columns);
    EXPECT_GT(expected.hessian.norm(), 1.0);
    EXPECT_LT((got.hessian - expected.hessian).norm(), 1e-9 * expected.hessian.norm());
    EXPECT_LT((got.gradient - expected.gradient).norm(), 1e-9 * expected.gradient.norm());
  }
}

TEST(WindowPoints, EliminationIsThatOfDenseMatrices) {
  const WindowProblem problem = testing::MakeWindowProblem(1, 0.1);
  WindowGeometry present;
  present.Set(problem, problem.world_from_body, {1e-3, 2e-3, -1e-3});
  ExpectSame(problem, present, present);
}

TEST(WindowPoints, DerivativesMayBeThoseOfAnotherState) {
  const WindowProblem problem = testing::MakeWindowProblem(2, 0.1);
  std::vector<Rigid3> first_estimates;
  std::mt19937_64 generator(3);
  for (const Rigid3& pose : problem.world_from_body) {
    PoseTangent step;
    step << testing::UniformVector(generator, 0.05), testing::UniformVector(generator, 0.01);
    first_estimates.push_back(Plus(pose, step));
  }
  WindowGeometry present, other;
  present.Set(problem, problem.world_from_body, problem.turn);
  other.Set(problem, first_estimates, problem.turn);
  ExpectSame(problem, present, other);
  const WindowColumns columns{.frames = testing::kWindowFrames, .has_turn = true};
  const Reduced at_other = ByWindowPoints(problem, present, other, columns);
  const Reduced at_present = ByWindowPoints(problem, present, present, columns);
  EXPECT_GT((at_other.hessian - at_present.hessian).norm(), 1e-3 * at_present.hessian.norm());
}

// Where the left camera turns about itself, its views say nothing of depths.
TEST(WindowPoints, APointWithoutDepthSaysLess) {
  WindowProblem problem = testing::MakeWindowProblem(4, 0.0);
  std::vector<WindowProblem::View> left_views;
  for (WindowProblem::Point& point : problem.points) {
    const int first = static_cast<int>(left_views.size());
    for (int v = point.first_view; v < point.end_view; ++v) {
      if (problem.views[static_cast<std::size_t>(v)].camera == 0) {
        left_views.push_back(problem.views[static_cast<std::size_t>(v)]);
      }
    }
    point.first_view = first;
    point.end_view = static_cast<int>(left_views.size());
  }
  problem.views = left_views;
  for (Rigid3& pose : problem.world_from_body) {
    pose.translation = -(pose.rotation * problem.body_from_cam[0].translation);
  }
  WindowGeometry present;
  present.Set(problem, problem.world_from_body, problem.turn);
  ExpectSame(problem, present, present);
}

}  // namespace
}  // namespace gluevo::vo
