#include "window_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <tuple>
#include <vector>

#include "vo/scene.h"
#include "window_ceres.h"

namespace gluevo::vo {
namespace {

constexpr int kFrames = 8;

Rigid3 PoseAt(int frame) {
  const double t = 0.3 * frame;
  return {ExpSo3({0.1 * std::sin(t), 0.05 * t, 0.3 * t}),
          {0.4 * t, 0.2 * std::sin(t), 0.1 * std::cos(t)}};
}

/// A wall of points seen by all frames with noise, a share of them wrong; poses and points start
/// away from the truth.
WindowProblem MakeProblem(std::uint64_t seed, double outlier_share) {
  std::mt19937_64 generator(seed);
  const StereoRig rig = testing::SimulatedRig();
  WindowProblem problem;
  problem.body_from_cam = rig.body_from_cam;
  problem.weight = 460.0 / 0.5;
  problem.turn_sigma = 5e-4;
  problem.turn_so_far = {1e-4, -2e-4, 5e-5};
  for (int i = 0; i < kFrames; ++i) {
    PoseTangent error;
    error << testing::UniformVector(generator, 0.02), testing::UniformVector(generator, 0.005);
    problem.world_from_body.push_back(i == 0 ? PoseAt(i) : Plus(PoseAt(i), error));
  }
  for (const Eigen::Vector3d& in_world : testing::RoomPoints(2000, 6.0, seed)) {
    WindowProblem::Point point{.anchor = -1, .first_view = static_cast<int>(problem.views.size())};
    for (int frame = 0; frame < kFrames; ++frame) {
      for (int camera = 0; camera < 2; ++camera) {
        Eigen::Vector2d seen;
        if (!testing::Observe(rig, camera, PoseAt(frame), in_world, seen) ||
            (camera == 1 && point.anchor < 0)) {
          continue;
        }
        const double noise = testing::Uniform(generator, 0.0, 1.0) < outlier_share ? 20.0 : 0.5;
        seen += noise / 460.0 *
                Eigen::Vector2d(testing::Gaussian(generator), testing::Gaussian(generator));
        if (point.anchor < 0) {
          const Eigen::Vector3d in_cam =
              (PoseAt(frame) * rig.body_from_cam[0]).Inverse() * in_world;
          point.anchor = frame;
          point.position << seen, (1.0 + 0.1 * testing::Gaussian(generator)) / in_cam.z();
        }
        problem.views.push_back({frame, camera, seen});
      }
    }
    point.end_view = static_cast<int>(problem.views.size());
    if (point.end_view - point.first_view > 2) {
      problem.points.push_back(point);
    }
  }
  return problem;
}

PosePrior MakePrior(const WindowProblem& problem) {
  std::mt19937_64 generator(7);
  PosePrior prior;
  prior.frame_ids = {0, 1, 2};
  prior.jacobian.resize(21, 21);
  for (double& value : prior.jacobian.reshaped()) {
    value = testing::Uniform(generator, -30.0, 30.0);
  }
  prior.residual = Eigen::VectorXd::Constant(21, 0.3);
  for (int i = 0; i < 3; ++i) {
    PoseTangent step;
    step << testing::UniformVector(generator, 0.01), testing::UniformVector(generator, 0.05);
    prior.world_from_body.push_back(
        Plus(problem.world_from_body[static_cast<std::size_t>(i)], step));
  }
  return prior;
}

void SetPrior(const PosePrior& prior, WindowProblem& problem) {
  problem.prior = &prior;
  problem.prior_frames = {0, 1, 2};
  problem.prior_turn_so_far = {-1e-4, 1e-4, 0.0};
}

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
    WindowProblem problem = MakeProblem(seed, outlier_share);
    ASSERT_GT(problem.points.size(), 100U);
    const PosePrior prior = MakePrior(problem);
    if (has_prior) {
      SetPrior(prior, problem);
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
    EXPECT_EQ(by_us.turn.norm() > 0.0, has_turn);
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
  const WindowProblem problem = MakeProblem(4, 0.1);
  WindowProblem first = problem;
  WindowProblem second = problem;
  WindowSolver solver;
  ASSERT_TRUE(solver.Solve(first, {}));
  ASSERT_TRUE(solver.Solve(second, {}));
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(first.world_from_body[i].translation, second.world_from_body[i].translation);
  }
}

TEST(WindowSolver, LeavesAloneWhatIsNotFinite) {
  WindowProblem problem = MakeProblem(5, 0.0);
  problem.world_from_body[3].translation.x() = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d before = problem.world_from_body[2].translation;
  EXPECT_FALSE(WindowSolver().Solve(problem, {}));
  EXPECT_EQ(problem.world_from_body[2].translation, before);
}

TEST(WindowGeometry, JacobiansMatchCentralDifferences) {
  const WindowProblem problem = MakeProblem(6, 0.0);
  const Eigen::Vector3d turn(0.01, -0.02, 0.015);
  WindowGeometry geometry;
  int checked = 0;
  for (std::size_t p = 0; p < problem.points.size(); p += 40) {
    const WindowProblem::Point& point = problem.points[p];
    for (int v = point.first_view; v < point.end_view; ++v) {
      const WindowProblem::View& view = problem.views[static_cast<std::size_t>(v)];
      geometry.Set(problem, problem.world_from_body, turn);
      const ReprojectionRows rows = geometry.Linearize(problem, view, point.anchor, point.position);
      ASSERT_TRUE(rows.is_in_front);
      EXPECT_EQ(rows.residual, geometry.Residual(problem, view, point.anchor, point.position));
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
        expect(rows.by_point.col(k),
               [&](double step, auto&, auto&, Eigen::Vector3d& position) { position[k] += step; });
        if (view.camera == 1) {
          expect(rows.by_turn.col(k),
                 [&](double step, auto&, Eigen::Vector3d& moved, auto&) { moved[k] += step; });
        }
      }
      for (int k = 0; view.frame != point.anchor && k < kPoseTangentSize; ++k) {
        const auto move_pose = [&](int frame) {
          return [frame, k](double step, std::vector<Rigid3>& poses, auto&, auto&) {
            Rigid3& pose = poses[static_cast<std::size_t>(frame)];
            pose = Plus(pose, step * PoseTangent::Unit(k));
          };
        };
        expect(rows.by_anchor.col(k), move_pose(point.anchor));
        expect(rows.by_frame.col(k), move_pose(view.frame));
      }
    }
  }
  EXPECT_GT(checked, 500);
}

}  // namespace
}  // namespace gluevo::vo
