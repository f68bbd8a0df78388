#include "gluevo/vo/pipeline/motion_history.h"

#include <gtest/gtest.h>

namespace gluevo::vo {
namespace {

StampedPose At(int64_t timestamp_ns, double x) {
  return {timestamp_ns, {Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}};
}

TEST(MotionHistory, GuessesRestAndTheLastMotionOnceMore) {
  MotionHistory history;
  EXPECT_FALSE(history.last());
  EXPECT_TRUE(history.Guesses().empty());
  history.Add(At(1, 1.0), /*starts_segment=*/true);
  ASSERT_EQ(history.Guesses().size(), 1U);
  history.Add(At(2, 3.0), /*starts_segment=*/false);
  const std::vector<Rigid3> guesses = history.Guesses();
  ASSERT_EQ(guesses.size(), 2U);
  EXPECT_DOUBLE_EQ(guesses[0].translation.x(), 3.0);
  EXPECT_DOUBLE_EQ(guesses[1].translation.x(), 5.0);
}

TEST(MotionHistory, AMotionAcrossABreakIsNone) {
  MotionHistory history;
  history.Add(At(1, 1.0), /*starts_segment=*/true);
  history.Add(At(2, 3.0), /*starts_segment=*/false);
  history.Add(At(3, 3.0), /*starts_segment=*/true);
  ASSERT_EQ(history.Guesses().size(), 1U);
  EXPECT_DOUBLE_EQ(history.Guesses()[0].translation.x(), 3.0);
  history.Add(At(4, 4.0), /*starts_segment=*/false);
  ASSERT_EQ(history.Guesses().size(), 2U);
  EXPECT_DOUBLE_EQ(history.Guesses()[1].translation.x(), 5.0);
}

TEST(MotionHistory, PredictsAMotionThatComesToRest) {
  constexpr int64_t kSecond = 1'000'000'000;
  MotionHistory history;
  history.Add(At(0, 1.0), /*starts_segment=*/true);
  EXPECT_DOUBLE_EQ(history.Predict(kSecond).translation.x(), 1.0);
  history.Add(At(kSecond / 10, 1.2), /*starts_segment=*/false);
  // 2 m/s: a tenth of a second later nearly as far again, in the end a metre on.
  EXPECT_NEAR(history.Predict(kSecond / 5).translation.x(), 1.38, 0.005);
  EXPECT_NEAR(history.Predict(100 * kSecond).translation.x(), 2.2, 1e-9);
}

}  // namespace
}  // namespace gluevo::vo
