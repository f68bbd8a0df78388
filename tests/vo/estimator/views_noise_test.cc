#include "gluevo/vo/estimator/views_noise.h"

#include <gtest/gtest.h>

namespace gluevo::vo {
namespace {

TEST(ViewsNoiseTest, IsLearnedFromWindowsThatSaySomething) {
  ViewsNoise noise;
  const double unknown = noise.Factor();
  noise.Learn(9.0, 10.0);  // Too few views.
  EXPECT_EQ(noise.Factor(), unknown);
  noise.Learn(0.25, 500.0);
  const double first = noise.Factor();
  noise.Learn(0.07, 500.0);
  EXPECT_NEAR(noise.Factor(), 0.8 * first, 1e-12);  // Of the mean, 0.16.
  // One bad window among many changes little, many do.
  for (int i = 0; i < 100; ++i) {
    noise.Learn(0.16, 500.0);
  }
  noise.Learn(1.0, 500.0);
  EXPECT_LT(noise.Factor(), 0.86 * first);
  for (int i = 0; i < 400; ++i) {
    noise.Learn(4.0, 500.0);
  }
  EXPECT_NEAR(noise.Factor(), 4.0 * first, 0.02 * first);
}

TEST(ViewsNoiseTest, StaysWithinBounds) {
  ViewsNoise noise;
  noise.Learn(0.0, 500.0);
  EXPECT_EQ(noise.Factor(), 0.1);
  ViewsNoise wild;
  wild.Learn(1e9, 500.0);
  EXPECT_EQ(wild.Factor(), 10.0);
}

}  // namespace
}  // namespace gluevo::vo
