#include "stamp_watch.h"

#include <gtest/gtest.h>

#include <vector>

#include "latency_histogram.h"

namespace gluevo::vo::internal {
namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kStep = 50 * kMs;

TEST(StampWatchTest, StampsInOrderGoOnAsTheyAre) {
  StampWatch watch("camera");
  for (int i = 0; i < 100; ++i) {
    // Arrival is as uneven as it likes.
    const StampWatch::Judged judged =
        watch.Judge(i * kStep, i * kStep + (i % 7) * 100 * kMs, /*other_shift_ns=*/0);
    EXPECT_EQ(judged.timestamp_ns, i * kStep);
    EXPECT_EQ(judged.warning, "");
  }
  EXPECT_EQ(watch.still() + watch.back() + watch.steps(), 0);
}

TEST(StampWatchTest, StampsThatStandStillOrGoBackALittleAreLeftOutAndToldOnce) {
  StampWatch watch("camera");
  watch.Judge(1000 * kMs, 1010 * kMs, 0);
  const StampWatch::Judged still = watch.Judge(1000 * kMs, 1060 * kMs, 0);
  EXPECT_FALSE(still.timestamp_ns);
  EXPECT_EQ(still.warning, "the camera's stamps stand still: left out");
  EXPECT_EQ(watch.Judge(1000 * kMs, 1110 * kMs, 0).warning, "");
  EXPECT_EQ(watch.Judge(1150 * kMs, 1160 * kMs, 0).timestamp_ns, 1150 * kMs);
  const StampWatch::Judged back = watch.Judge(1100 * kMs, 1210 * kMs, 0);
  EXPECT_FALSE(back.timestamp_ns);
  EXPECT_EQ(back.warning, "the camera's stamps go back by 0.05 s: left out");
  EXPECT_EQ(watch.Judge(1250 * kMs, 1260 * kMs, 0).timestamp_ns, 1250 * kMs);
  EXPECT_EQ(watch.still(), 2);
  EXPECT_EQ(watch.back(), 1);
  EXPECT_EQ(watch.steps(), 0);
}

TEST(StampWatchTest, AClockThatStepsIsFollowed) {
  for (const int64_t step : {-3'000 * kMs, 5'000 * kMs}) {
    StampWatch watch("camera");
    int64_t last = -1;
    std::vector<std::string> warnings;
    for (int i = 0; i < 40; ++i) {
      const int64_t now = 10'000 * kMs + i * kStep;
      const StampWatch::Judged judged = watch.Judge(now - 10 * kMs + (i < 20 ? 0 : step), now, 0);
      ASSERT_TRUE(judged.timestamp_ns);
      if (i > 0) {
        EXPECT_EQ(*judged.timestamp_ns - last, kStep) << i;
      }
      last = *judged.timestamp_ns;
      if (!judged.warning.empty()) {
        warnings.push_back(judged.warning);
      }
    }
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_EQ(warnings[0], step < 0 ? "the camera's clock stepped back by 3 s: its stamps go on as "
                                      "if it had not"
                                    : "the camera's clock stepped ahead by 5 s: its stamps go on "
                                      "as if it had not");
    EXPECT_EQ(watch.steps(), 1);
    EXPECT_EQ(watch.shift_ns(), -step);
  }
}

TEST(StampWatchTest, TwoSensorsOfOneClockStepByTheSame) {
  StampWatch camera("camera");
  StampWatch unit("inertial unit");
  camera.Judge(0, 0, 0);
  unit.Judge(0, 0, 0);
  // Both are late by other times when the clock has stepped back by four seconds.
  camera.Judge(50 * kMs - 4'000 * kMs, 77 * kMs, unit.shift_ns());
  EXPECT_EQ(unit.Judge(55 * kMs - 4'000 * kMs, 56 * kMs, camera.shift_ns()).timestamp_ns,
            55 * kMs - 4'000 * kMs + camera.shift_ns());
  EXPECT_EQ(unit.shift_ns(), camera.shift_ns());
}

TEST(StampWatchTest, FramesThatAreMissingAreNoStep) {
  StampWatch watch("camera");
  watch.Judge(0, 0, 0);
  EXPECT_EQ(watch.Judge(8'000 * kMs, 8'000 * kMs, 0).timestamp_ns, 8'000 * kMs);
  // One that was long under way, and then those that come at once again.
  EXPECT_EQ(watch.Judge(8'050 * kMs, 12'000 * kMs, 0).timestamp_ns, 8'050 * kMs);
  EXPECT_EQ(watch.Judge(12'050 * kMs, 12'050 * kMs, 0).timestamp_ns, 12'050 * kMs);
  EXPECT_EQ(watch.steps(), 0);
}

TEST(LatencyHistogramTest, QuantilesAreWithinAPercent) {
  LatencyHistogram histogram;
  EXPECT_EQ(histogram.Quantile(0.5), 0.0);
  for (int i = 1; i <= 1000; ++i) {
    histogram.Add(0.1 * i);
  }
  histogram.Add(-1.0);  // A clock that is wrong is no crash.
  EXPECT_NEAR(histogram.Quantile(0.5), 50.0, 0.6);
  EXPECT_NEAR(histogram.Quantile(0.95), 95.0, 1.0);
  EXPECT_EQ(histogram.max_ms(), 100.0);
  EXPECT_NEAR(histogram.Quantile(1.0), 100.0, 1.0);
}

}  // namespace
}  // namespace gluevo::vo::internal
