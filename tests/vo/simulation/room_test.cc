// Rooms whose parts look alike.

#include "room.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "gluevo/vo/simulation/simulation.h"
#include "path.h"
#include "renderer.h"

namespace gluevo::simulation {
namespace {

constexpr double kTwinM = 6.0;

RoomStyle TwinStyle() {
  RoomStyle style{0.02, 0.02};
  style.twin_m = kTwinM;
  return style;
}

TEST(Twins, PartsOfARoomLookAlikeAcrossAndNotBetween) {
  const RoomPlan plan{{0.0, 0.0, 0.0}, {3.0 * kTwinM, 7.0, 4.0}};
  const SimulatedWorld world = MakeRoom(3, plan, {{9.0, 3.5, 1.5}}, TwinStyle(), 2);
  ASSERT_GE(world.boxes.size(), 6U);
  EXPECT_EQ(world.boxes.size() % 3, 0U);
  const vo::StereoRig rig = SimulationRig(376, 240);
  const Renderer renderer(rig, 2);
  // Across the room from its wall: the ends are out of sight.
  const auto look = [&](double x) {
    vo::Rigid3 world_from_body;
    // Body: x up, y right, z forward; forward is the world's y.
    Eigen::Matrix3d axes;
    axes << 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0;
    world_from_body.rotation = Eigen::Quaterniond(axes);
    world_from_body.translation = {x, 0.3, 1.5};
    return renderer.Render(world, 0, {world_from_body});
  };
  // Gray levels.
  const auto difference = [](const cv::Mat& a, const cv::Mat& b) {
    return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
  };
  const cv::Mat here = look(5.0);
  EXPECT_LT(difference(here, look(5.0 + kTwinM)), 5.0);
  EXPECT_GT(difference(here, look(5.0 + 0.5 * kTwinM)), 10.0);
}

}  // namespace
}  // namespace gluevo::simulation
