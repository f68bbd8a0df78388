#include "gluevo/vo/pipeline/still_views.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kFrameNs = 100'000'000;

class StillViewsTest : public ::testing::Test {
 protected:
  StillViewsTest() : points_(testing::RoomPoints(3000, 6.0, 1)) {
    const Rigid3 left_cam_from_world = rig_.body_from_cam[0].Inverse();
    std::vector<MapPoint> map;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      map.push_back({static_cast<int64_t>(i), points_[i]});
    }
    views_.Begin(Frame({}, 0), map, left_cam_from_world);
  }

  /// Seen from there.
  TrackedFrame Frame(const Rigid3& world_from_body, int number) const {
    return testing::Simulate(rig_, points_, world_from_body, number * kFrameNs, {});
  }
  /// Frames until a motion at that speed shows; 50 where it does not.
  int ShowsAfter(const PoseTangent& speed) const {
    int number = 1;
    while (number < 50 &&
           views_.Compare(Frame(Plus(Rigid3{}, PoseTangent(0.1 * number * speed)), number))) {
      ++number;
    }
    return number;
  }

  StereoRig rig_ = testing::SimulatedRig();
  std::vector<Eigen::Vector3d> points_;
  StillViews views_;
};

TEST_F(StillViewsTest, KnowsSinceWhenTheRigStandsAndHowWell) {
  ASSERT_TRUE(views_.has_begun());
  for (int number = 1; number < 50; ++number) {
    const std::optional<StillViews::Still> still = views_.Compare(Frame({}, number));
    ASSERT_TRUE(still) << number;
    EXPECT_DOUBLE_EQ(still->since_s, 0.1 * number);
    EXPECT_GT(still->position_sigma_m, 1e-4);
    EXPECT_LT(still->position_sigma_m, 1e-2);
    EXPECT_GT(still->rotation_sigma_rad, 2e-5);
    EXPECT_LT(still->rotation_sigma_rad, 1e-3);
  }
}

TEST_F(StillViewsTest, AMotionShowsSoonerTheFasterItIs) {
  PoseTangent sideways = PoseTangent::Zero();
  sideways[1] = 1.0;
  PoseTangent turning = PoseTangent::Zero();
  turning[5] = 1.0;
  EXPECT_LE(ShowsAfter(0.2 * sideways), 1);
  EXPECT_LE(ShowsAfter(0.01 * sideways), 5);
  EXPECT_LE(ShowsAfter(0.002 * sideways), 20);
  EXPECT_LE(ShowsAfter(0.002 * turning), 5);
}

TEST_F(StillViewsTest, WhatMovesBeforeARigThatStandsDoesNotMoveIt) {
  TrackedFrame frame = Frame({}, 5);
  for (std::size_t i = 0; i < frame.observations.size(); i += 3) {
    frame.observations[i].left.x() += 0.05;
  }
  EXPECT_TRUE(views_.Compare(frame));
}

TEST_F(StillViewsTest, FewTracksSayNothing) {
  TrackedFrame frame = Frame({}, 1);
  frame.observations.resize(15);
  EXPECT_FALSE(views_.Compare(frame));
}

}  // namespace
}  // namespace gluevo::vo
