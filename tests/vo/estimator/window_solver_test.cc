#include "window_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <tuple>
#include <vector>

#include "window_ceres.h"
#include "window_reprojection.h"
#include "window_scene.h"

namespace gluevo::vo {
namespace {

constexpr WindowSolverLimits kUntilConverged{.max_iterations = 100, .least_decrease = 1e-14};

double LargestDistance(const WindowProblem& a, const WindowProblem& b) {
  double largest = (a.turn - b.turn).norm();
  for (std::size_t i = 0; i < a.world_from_body.size(); ++i) {
    largest = std::max(largest, Minus(a.world_from_body[i], b.world_from_body[i]).norm());
  }
  return largest;
}

class WindowSolverTest : public ::testing::TestWithParam<std::tuple<double, bool, bool>> {};

TEST_P(WindowSolverTest, AgreesWithCeres) {
  const auto& [outlier_share, has_prior, has_turn] = GetParam();
  for (const std::uint64_t seed : {1, 2, 3}) {
    WindowProblem problem = testing::MakeWindowProblem(seed, outlier_share);
    problem.bend = seed == 2 ? 0.0 : 1.0;
    ASSERT_GT(problem.points.size(), 40U);
    const PosePrior prior = testing::MakePrior(problem);
    if (has_prior) {
      testing::SetPrior(prior, problem);
    }
    if (!has_turn) {
      problem.turn_sigma = 0.0;
    }
    WindowProblem by_ceres = problem;
    WindowProblem by_us = problem;
    ASSERT_TRUE(SolveByCeres(by_ceres, kUntilConverged));
    WindowSolver solver;
    ASSERT_TRUE(solver.Solve(by_us, kUntilConverged));
    EXPECT_GT(LargestDistance(problem, by_us), 1e-3);
    EXPECT_LT(LargestDistance(by_ceres, by_us), 1e-6);
    EXPECT_EQ(by_us.turn != problem.turn, has_turn);
    // Step by step, too: the same rules for the damping.
    by_ceres = by_us = problem;
    ASSERT_TRUE(SolveByCeres(by_ceres, {.max_iterations = 3}));
    ASSERT_TRUE(solver.Solve(by_us, {.max_iterations = 3}));
    EXPECT_EQ(solver.iterations(), 3);
    EXPECT_LT(LargestDistance(by_ceres, by_us), 1e-7);
  }
}

INSTANTIATE_TEST_SUITE_P(All, WindowSolverTest,
                         ::testing::Combine(::testing::Values(0.0, 0.1), ::testing::Bool(),
                                            ::testing::Bool()));

TEST(WindowSolver, RepeatsToTheLastBit) {
  const WindowProblem problem = testing::MakeWindowProblem(4, 0.1);
  WindowProblem first = problem;
  WindowProblem second = problem;
  WindowSolver solver;
  ASSERT_TRUE(solver.Solve(first, {}));
  ASSERT_TRUE(solver.Solve(second, {}));
  for (int i = 0; i < testing::kWindowFrames; ++i) {
    EXPECT_EQ(first.world_from_body[i].translation, second.world_from_body[i].translation);
  }
}

TEST(WindowSolver, LeavesAloneWhatIsNotFinite) {
  WindowProblem problem = testing::MakeWindowProblem(5, 0.0);
  problem.world_from_body[3].translation.x() = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d before = problem.world_from_body[2].translation;
  EXPECT_FALSE(WindowSolver().Solve(problem, {}));
  EXPECT_EQ(problem.world_from_body[2].translation, before);
}

class WindowGeometryTest : public ::testing::TestWithParam<double> {};

TEST_P(WindowGeometryTest, JacobiansMatchCentralDifferences) {
  WindowProblem problem = testing::MakeWindowProblem(6, 0.0);
  problem.bend = GetParam();
  const Eigen::Vector3d turn(0.01, -0.02, 0.015);
  WindowGeometry geometry;
  int checked = 0;
  for (std::size_t p = 0; p < problem.points.size(); p += 10) {
    const WindowProblem::Point& point = problem.points[p];
    for (int v = point.first_view; v < point.end_view; ++v) {
      const WindowProblem::View& view = problem.views[static_cast<std::size_t>(v)];
      geometry.Set(problem, problem.world_from_body, turn);
      const ReprojectionColumns columns =
          geometry.Linearize(problem, view, point.anchor, point.position);
      ASSERT_TRUE(columns.is_in_front);
      EXPECT_EQ(columns.residual, geometry.Residual(problem, view, point.anchor, point.position));
      // `move(poses, turn, position)` by a small step: the derivative's column.
      const auto expect = [&](const Eigen::Vector2d& analytic, auto move) {
        const auto at = [&](double step) {
          std::vector<Rigid3> poses = problem.world_from_body;
          Eigen::Vector3d moved_turn = turn;
          Eigen::Vector3d position = point.position;
          move(step, poses, moved_turn, position);
          geometry.Set(problem, poses, moved_turn);
          return geometry.Residual(problem, view, point.anchor, position);
        };
        constexpr double kStep = 1e-3;
        const Eigen::Vector2d numeric =
            (8.0 * (at(kStep) - at(-kStep)) - (at(2 * kStep) - at(-2 * kStep))) / (12.0 * kStep);
        EXPECT_LT((analytic - numeric).norm(), 1e-6 * (problem.weight + numeric.norm()));
        ++checked;
      };
      for (int k = 0; k < 3; ++k) {
        expect(columns.by_point.row(k),
               [&](double step, auto&, auto&, Eigen::Vector3d& position) { position[k] += step; });
        if (view.camera == 1) {
          expect(columns.by_turn.row(k),
                 [&](double step, auto&, Eigen::Vector3d& moved, auto&) { moved[k] += step; });
        }
      }
      if (view.frame == point.anchor) {
        continue;
      }
      const Eigen::Matrix<double, 2, 6> by_anchor =
          columns.by_relative.transpose() * geometry.RelativeByAnchor(point.anchor);
      const Eigen::Matrix<double, 2, 6> by_frame =
          columns.by_relative.transpose() * geometry.RelativeByFrame(point.anchor, view.frame);
      for (int k = 0; k < kPoseTangentSize; ++k) {
        const auto move_pose = [&](int frame) {
          return [frame, k](double step, std::vector<Rigid3>& poses, auto&, auto&) {
            Rigid3& pose = poses[static_cast<std::size_t>(frame)];
            pose = Plus(pose, step * PoseTangent::Unit(k));
          };
        };
        expect(by_anchor.col(k), move_pose(point.anchor));
        expect(by_frame.col(k), move_pose(view.frame));
      }
    }
  }
  EXPECT_GT(checked, 300);
}

INSTANTIATE_TEST_SUITE_P(Bends, WindowGeometryTest, ::testing::Values(0.0, 0.5, 1.0));

}  // namespace
}  // namespace gluevo::vo
