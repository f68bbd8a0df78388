// Bundle adjustment asks the system for no memory once it has solved a window of the size.

#include <gtest/gtest.h>

#include "count_allocations.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "window_scene.h"
#include "window_solver.h"

namespace gluevo::vo {
namespace {

class WindowAllocationsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (GLUEVO_COUNTS_ALLOCATIONS == 0) {
      GTEST_SKIP() << "allocations are not counted under a sanitiser";
    }
  }
};

TEST_F(WindowAllocationsTest, Solver) {
  WindowProblem problem = testing::MakeWindowProblem(1, 0.1);
  const PosePrior prior = testing::MakePrior(problem);
  testing::SetPrior(prior, problem);
  WindowProblem again = problem;
  WindowProblem smaller = problem;
  smaller.points.resize(problem.points.size() / 2);
  WindowSolver solver;
  const auto solve = [&](WindowProblem& which) {
    return AllocationsOf([&] { ASSERT_TRUE(solver.Solve(which, {})); });
  };
  EXPECT_GT(solve(problem), 0);
  EXPECT_GT(solver.iterations(), 2);
  EXPECT_EQ(solve(again), 0);
  EXPECT_EQ(solve(smaller), 0);
}

TEST_F(WindowAllocationsTest, SlidingWindow) {
  const StereoRig rig = testing::SimulatedRig();
  SlidingWindow window(rig, {});
  const auto points = testing::RoomPoints(500, 6.0, 1);
  for (int i = 0; i < 5; ++i) {
    const Rigid3 pose = testing::WindowPoseAt(i);
    const TrackedFrame frame = testing::Simulate(rig, points, pose, 1 + i, {});
    window.AddFrame(frame, pose, std::vector<std::optional<PnpVerdict>>(frame.observations.size()));
    window.Triangulate();
  }
  const auto optimize = [&] { return AllocationsOf([&] { ASSERT_TRUE(window.Optimize()); }); };
  ASSERT_GT(window.CountLandmarks(), 50U);
  EXPECT_GT(optimize(), 0);
  EXPECT_EQ(optimize(), 0);
}

}  // namespace
}  // namespace gluevo::vo
