#include "axis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "view_axes.h"

namespace gluevo::apps {
namespace {

TEST(RoundTicksTest, AreRoundAndNeverTooMany) {
  const Ticks ticks = RoundTicks(0.0, 10.0, 6);
  EXPECT_EQ(ticks.values, (std::vector<double>{0.0, 2.0, 4.0, 6.0, 8.0, 10.0}));
  EXPECT_EQ(ticks.decimals, 0);
  const Ticks small = RoundTicks(-0.0123, 0.0351, 6);
  ASSERT_EQ(small.values.size(), 5U);
  EXPECT_NEAR(small.values[0], -0.01, 1e-12);
  EXPECT_NEAR(small.values[4], 0.03, 1e-12);
  EXPECT_EQ(small.decimals, 2);
  for (const int most : {2, 3, 5, 8}) {
    for (double extent = 1e-7; extent < 1e7; extent *= 1.7) {
      for (const double low : {0.0, -0.4 * extent, 3.3 * extent, -1000.0 * extent}) {
        const Ticks any = RoundTicks(low, low + extent, most);
        EXPECT_LE(any.values.size(), static_cast<std::size_t>(most)) << low << ' ' << extent;
        for (const double value : any.values) {
          EXPECT_GE(value, low - 1e-6 * extent);
          EXPECT_LE(value, low + extent * (1.0 + 1e-6));
          // As many decimals as the step needs: the label is the value.
          const double scale = std::pow(10.0, any.decimals);
          EXPECT_NEAR(std::round(value * scale) / scale, value, 1e-6 * extent);
        }
      }
    }
  }
}

TEST(MakeAxisTest, WidensWhatHasNoExtentAndRoundsItsEnds) {
  const Axis still = MakeAxis(5.0, 5.0, 5, /*round=*/false);
  EXPECT_LT(still.low, 5.0);
  EXPECT_GT(still.high, 5.0);
  const Axis zero = MakeAxis(0.0, 0.0, 5, /*round=*/true);
  EXPECT_EQ(zero.low, 0.0);
  EXPECT_GT(zero.high, 0.0);
  Axis axis = MakeAxis(0.0, 9.3, 6, /*round=*/true);
  EXPECT_EQ(axis.low, 0.0);
  EXPECT_EQ(axis.high, 10.0);
  axis.begin = 100.0;
  axis.end = 0.0;
  EXPECT_EQ(axis.Place(2.5), 75.0);
}

TEST(ViewAxesTest, NeverMirror) {
  const Eigen::AlignedBox3d wide(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(9, 1, 1));
  const Eigen::AlignedBox3d deep(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 9, 9));
  for (int index = 0; index < 3; ++index) {
    for (const double sign : {1.0, -1.0}) {
      for (const Eigen::AlignedBox3d& box : {wide, deep}) {
        Eigen::Vector3d up(0.2, 0.1, -0.3);
        up[index] = sign;
        const ViewAxes axes = ChooseViewAxes(up, box);
        const auto direction = [](const SignedAxis& axis) {
          Eigen::Vector3d unit = Eigen::Vector3d::Zero();
          unit[axis.index] = axis.sign;
          return unit;
        };
        EXPECT_EQ(axes.up.index, index);
        EXPECT_EQ(axes.up.sign, sign);
        EXPECT_EQ(direction(axes.right).cross(direction(axes.forward)), direction(axes.up));
        EXPECT_GE(box.sizes()[axes.right.index], box.sizes()[axes.forward.index]);
      }
    }
  }
}

}  // namespace
}  // namespace gluevo::apps
