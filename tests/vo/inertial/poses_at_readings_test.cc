#include "gluevo/vo/inertial/poses_at_readings.h"

#include <gtest/gtest.h>

#include "inertial_flight.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kBeginNs = 1'002'000'000;
constexpr int64_t kEndNs = 1'198'000'000;

double Distance(const Rigid3& a, const Rigid3& b) { return Minus(a, b).norm(); }

TEST(PosesAtReadingsTest, FollowTheFlightAndGoThroughBothFrames) {
  const InertialFlight flight(2, {}, /*is_ideal=*/true, 1);
  ImuReadings readings({});
  readings.Add(flight.samples);
  const StampedInertialState first = {kBeginNs, flight.StateAt(kBeginNs)};
  const Rigid3 end = flight.StateAt(kEndNs).world_from_body;
  const Trajectory poses = PosesAtReadings(first, {kEndNs, end}, flight.gravity, readings);
  ASSERT_EQ(poses.size(), 39U);
  EXPECT_EQ(poses.front().timestamp_ns, 1'005'000'000);
  EXPECT_EQ(poses.back().timestamp_ns, 1'195'000'000);
  for (const StampedPose& pose : poses) {
    EXPECT_LT(Distance(pose.world_from_body, flight.StateAt(pose.timestamp_ns).world_from_body),
              1e-4);
  }
  // A second frame elsewhere pulls the later half of the path farther than the earlier one.
  const Rigid3 moved = end * Rigid3{ExpSo3({0.0, 0.02, 0.0}), {0.1, 0.0, 0.0}};
  const Trajectory pulled =
      PosesAtReadings(first, {1'200'000'000, moved}, flight.gravity, readings);
  EXPECT_EQ(pulled.back().timestamp_ns, 1'200'000'000);
  EXPECT_LT(Distance(pulled.back().world_from_body, moved), 1e-9);
  EXPECT_LT(Distance(pulled.front().world_from_body, poses.front().world_from_body), 0.003);
}

TEST(PosesAtReadingsTest, AreNoneWhereReadingsDoNotReach) {
  const InertialFlight flight(1, {}, /*is_ideal=*/true, 1);
  ImuReadings readings({});
  readings.Add(flight.samples);
  EXPECT_TRUE(
      PosesAtReadings({900'000'000, {}}, {1'100'000'000, {}}, flight.gravity, readings).empty());
  EXPECT_TRUE(
      PosesAtReadings({500'000'000, {}}, {500'000'000, {}}, flight.gravity, readings).empty());
}

}  // namespace
}  // namespace gluevo::vo
