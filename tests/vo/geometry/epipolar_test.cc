#include "gluevo/vo/geometry/epipolar.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gluevo::vo {
namespace {

// Rectified, focal length 500 px, baseline 0.1 m: epipolar lines are rows.
StereoRig RectifiedRig() {
  StereoRig rig;
  for (Camera& camera : rig.cameras) {
    camera = {.width = 640, .height = 480, .fx = 500.0, .fy = 500.0, .cx = 320.0, .cy = 240.0};
  }
  rig.body_from_cam[1].translation = {0.1, 0.0, 0.0};
  return rig;
}

TEST(EpipolarCheckTest, DistanceIsTheRowDifferenceOfARectifiedRig) {
  const EpipolarCheck check(RectifiedRig());
  EXPECT_NEAR(check.Distance({0.2, 0.1}, {0.1, 0.1}), 0.0, 1e-12);
  EXPECT_NEAR(check.Distance({0.2, 0.1}, {0.1, 0.104}), 2.0, 1e-9);  // 0.004 * 500 px
  EXPECT_NEAR(check.Distance({0.2, 0.1}, {-0.3, 0.096}), 2.0, 1e-9);
}

TEST(EpipolarCheckTest, PointsInFrontHaveAPositiveDisparity) {
  const EpipolarCheck check(RectifiedRig());
  EXPECT_TRUE(check.InFront({0.2, 0.1}, {0.15, 0.1}, 1.0));
  EXPECT_TRUE(check.InFront({0.2, 0.1}, {0.2, 0.1}, 1.0));      // At infinity.
  EXPECT_TRUE(check.InFront({0.2, 0.1}, {0.2019, 0.1}, 1.0));   // Within a pixel of it.
  EXPECT_FALSE(check.InFront({0.2, 0.1}, {0.2021, 0.1}, 1.0));  // Beyond: behind the cameras.
}

TEST(EpipolarCheckTest, AllowsWhatIsNearTheLineInFrontAndHasRays) {
  const EpipolarCheck check(RectifiedRig());
  EXPECT_TRUE(check.Allows({0.2, 0.1}, {0.15, 0.101}, 1.0));
  EXPECT_FALSE(check.Allows({0.2, 0.1}, {0.15, 0.104}, 1.0));  // Two pixels off the line.
  EXPECT_FALSE(check.Allows({0.2, 0.1}, {0.25, 0.1}, 1.0));    // Behind.
  const double nan = std::nan("");
  EXPECT_FALSE(check.Allows({nan, nan}, {0.15, 0.1}, 1.0));
  EXPECT_FALSE(check.Allows({0.2, 0.1}, {nan, nan}, 1.0));
}

TEST(EpipolarCheckTest, TruePointsOfATurnedRigPass) {
  StereoRig rig = RectifiedRig();
  rig.body_from_cam[1].rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d(1.0, 2.0, -1.0).normalized()));
  rig.body_from_cam[1].translation = {0.1, 0.02, -0.03};
  const EpipolarCheck check(rig);
  for (const double depth : {0.5, 3.0, 1000.0}) {
    const Eigen::Vector3d in_left = depth * Eigen::Vector3d(-0.1, 0.2, 1.0);
    const Eigen::Vector2d right = (rig.right_from_left() * in_left).hnormalized();
    EXPECT_NEAR(check.Distance(in_left.hnormalized(), right), 0.0, 1e-9);
    EXPECT_TRUE(check.InFront(in_left.hnormalized(), right, 1e-6));
  }
}

}  // namespace
}  // namespace gluevo::vo
