// What the window's equations say of how good poses are, against how good they are.

#include <gtest/gtest.h>

#include <limits>

#include "window_equations.h"
#include "window_scene.h"
#include "window_solver.h"

namespace gluevo::vo {
namespace {

using Vector12 = Eigen::Matrix<double, 12, 1>;

WindowState StateOf(const WindowProblem& problem) {
  WindowState state{problem.world_from_body, problem.turn, {}};
  state.points.reserve(problem.points.size());
  for (const WindowProblem::Point& point : problem.points) {
    state.points.push_back(point.position);
  }
  return state;
}

// Of the last two frames, with noise that nothing makes robust against.
WindowProblem Solved(std::uint64_t seed, double turn_sigma) {
  WindowProblem problem = testing::MakeWindowProblem(seed, 0.0);
  problem.huber = std::numeric_limits<double>::max();
  problem.turn_sigma = turn_sigma;
  problem.turn.setZero();
  EXPECT_TRUE(WindowSolver().Solve(problem, {.max_iterations = 50, .least_decrease = 1e-12}));
  return problem;
}

TEST(WindowUncertainty, IsThatOfManyWindows) {
  constexpr int kWindows = 60;
  constexpr int kFirst = 2;
  constexpr int kSecond = testing::kWindowFrames - 1;
  double sum = 0.0;
  for (int seed = 1; seed <= kWindows; ++seed) {
    const WindowProblem problem = Solved(static_cast<std::uint64_t>(seed), 0.0);
    WindowEquations equations;
    equations.Set(problem);
    equations.Linearize(StateOf(problem));
    const auto covariance = equations.Covariance(kFirst, kSecond);
    ASSERT_TRUE(covariance);
    Vector12 error;
    error << Minus(testing::WindowPoseAt(kFirst), problem.world_from_body[kFirst]),
        Minus(testing::WindowPoseAt(kSecond), problem.world_from_body[kSecond]);
    sum += error.dot(covariance->ldlt().solve(error));
  }
  // Chi-square of 12 degrees of freedom: its mean over 60 has a standard deviation of 0.63.
  EXPECT_NEAR(sum / kWindows, 12.0, 3.0 * 0.63);
}

TEST(WindowUncertainty, AFixedFrameIsKnown) {
  const WindowProblem problem = Solved(3, 5e-4);
  WindowEquations equations;
  equations.Set(problem);
  equations.Linearize(StateOf(problem));
  const auto covariance = equations.Covariance(0, 1);
  ASSERT_TRUE(covariance);
  EXPECT_TRUE((covariance->topLeftCorner<6, 6>().isZero()));
  EXPECT_TRUE((covariance->topRightCorner<6, 6>().isZero()));
  EXPECT_GT(covariance->diagonal().tail<6>().minCoeff(), 0.0);
  // Later frames are known less well from the first one.
  const auto later = equations.Covariance(1, testing::kWindowFrames - 1);
  ASSERT_TRUE(later);
  EXPECT_TRUE((later->topLeftCorner<6, 6>().isApprox(covariance->bottomRightCorner<6, 6>())));
  EXPECT_GT((later->bottomRightCorner<3, 3>().trace()), (later->block<3, 3>(3, 3).trace()));
}

}  // namespace
}  // namespace gluevo::vo
