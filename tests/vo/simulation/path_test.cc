#include "path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gluevo/nn/error.h"
#include "gluevo/vo/simulation/simulation.h"

namespace gluevo::simulation {
namespace {

class NamedPathTest : public ::testing::TestWithParam<std::string> {};

TEST_P(NamedPathTest, StartsAtRestAndFliesAsABodyCan) {
  const SimulationPath path = MakeSimulationPath(GetParam());
  if (GetParam() != "straight") {
    const Motion start = MotionAt(path, 0.0);
    EXPECT_LT(start.velocity_in_world.norm(), 1e-5);
    EXPECT_LT(start.angular_velocity_in_body.norm(), 1e-5);
    EXPECT_LT((path(-1.0).translation - path(0.0).translation).norm(), 1e-12);
  }
  const double fastest = GetParam() == "street" ? 10.0 : 2.5;  // A car, or a body in a room.
  Motion last = MotionAt(path, 0.0);
  for (double time = 0.005; time < 45.0; time += 0.005) {
    const Motion next = MotionAt(path, time);
    EXPECT_LT(next.velocity_in_world.norm(), fastest) << time;
    EXPECT_LT(next.acceleration_in_world.norm(), 8.0) << time;
    EXPECT_LT(next.angular_velocity_in_body.norm(), 2.7) << time;
    // Neither force nor turning rate jumps.
    EXPECT_LT((next.acceleration_in_world - last.acceleration_in_world).norm(), 0.15) << time;
    EXPECT_LT((next.angular_velocity_in_body - last.angular_velocity_in_body).norm(), 0.05) << time;
    // Upright, within its nodding.
    EXPECT_GT(next.world_from_body.rotation.toRotationMatrix()(2, 0), 0.97) << time;
    last = next;
  }
}

INSTANTIATE_TEST_SUITE_P(All, NamedPathTest, ::testing::ValuesIn(SimulationPaths()),
                         [](const auto& instance) { return instance.param; });

TEST(NamedPath, LapsEndWhereTheyBegan) {
  for (const std::string name : {"hall_loop", "figure_eight", "corridor"}) {
    const SimulationPath path = MakeSimulationPath(name);
    for (const int laps : {1, 3}) {
      const vo::Rigid3 end = path(LapsEnd(name, laps));
      EXPECT_LT((end.translation - path(0.0).translation).norm(), 1e-6) << name;
      // At the corridor's end it is turning round.
      if (name != "corridor") {
        EXPECT_LT(end.rotation.angularDistance(path(0.0).rotation), 1e-6) << name;
      }
      EXPECT_GT((path(LapsEnd(name, laps) - 1.0).translation - end.translation).norm(), 0.1);
    }
  }
  EXPECT_THROW(LapsEnd("hover", 1), Error);
}

/// The direction of sight on the ground.
double Yaw(const vo::Rigid3& pose) {
  const Eigen::Vector3d forward = pose.rotation * Eigen::Vector3d::UnitZ();
  return std::atan2(forward.y(), forward.x());
}

TEST(SimulationPathTest, WhatAnInertialUnitNeedsIsMissing) {
  const SimulationPath rest = MakeSimulationPath("rest");
  const SimulationPath straight = MakeSimulationPath("straight");
  const SimulationPath spin = MakeSimulationPath("spin");
  const SimulationPath planar = MakeSimulationPath("planar");
  for (double time = 0.0; time < 20.0; time += 0.05) {
    EXPECT_LT((rest(time).translation - rest(0.0).translation).norm(), 1e-12);
    EXPECT_LT(rest(time).rotation.angularDistance(rest(0.0).rotation), 1e-6);
    EXPECT_LT(MotionAt(straight, time).acceleration_in_world.norm(), 1e-6);
    EXPECT_LT(MotionAt(straight, time).angular_velocity_in_body.norm(), 1e-6);
    EXPECT_LT((spin(time).translation - spin(0.0).translation).norm(), 1e-12);
    EXPECT_EQ(planar(time).translation.z(), planar(0.0).translation.z());
    EXPECT_NEAR(planar(time).rotation.toRotationMatrix()(2, 0), 1.0, 1e-12);
  }
  EXPECT_GT(straight(20.0).translation.x(), 5.0);
  EXPECT_GT(MotionAt(spin, 10.0).angular_velocity_in_body.norm(), 0.1);
}

TEST(SimulationPathTest, PathsDoWhatTheirNamesSay) {
  const SimulationPath hover = MakeSimulationPath("hover");
  const SimulationPath yaw = MakeSimulationPath("fast_yaw");
  const SimulationPath corridor = MakeSimulationPath("corridor");
  const SimulationPath eight = MakeSimulationPath("figure_eight");
  double fastest = 0.0;
  int left = 0;
  int right = 0;
  for (double time = 0.0; time < 20.0; time += 0.05) {
    EXPECT_LT((hover(time).translation - hover(0.0).translation).norm(), 0.3);
    EXPECT_LT(hover(time).rotation.angularDistance(hover(0.0).rotation), 0.15);
    EXPECT_LT(yaw(time).translation.head<2>().norm(), 0.4);
    fastest = std::max(fastest, MotionAt(yaw, time).angular_velocity_in_body.norm());
    EXPECT_LT(std::abs(corridor(time).translation.y()), 0.2);
    // About the body's x, which points up.
    const double turn = MotionAt(eight, time).angular_velocity_in_body.x();
    left += turn > 0.2 ? 1 : 0;
    right += turn < -0.2 ? 1 : 0;
  }
  EXPECT_GT(fastest, 2.2);
  EXPECT_GT(left, 100);
  EXPECT_GT(right, 100);
  // Eased by a second: half-way at 11 s, back at 21 s.
  EXPECT_NEAR(corridor(11.0).translation.x() - corridor(0.0).translation.x(), 12.0, 0.01);
  EXPECT_NEAR(corridor(21.0).translation.x(), corridor(0.0).translation.x(), 0.01);
  EXPECT_LT(std::abs(Yaw(corridor(6.0))), 0.15);
  EXPECT_GT(std::abs(Yaw(corridor(16.0))), 3.0);
}

}  // namespace
}  // namespace gluevo::simulation
