#include "gluevo/vo/frontend/freeze_guard.h"

#include <gtest/gtest.h>

#include <memory>
#include <opencv2/core.hpp>

#include "gluevo/nn/error.h"
#include "textured_views.h"

namespace gluevo::vo {
namespace {

// What the guarded front end was told.
struct Record {
  int tracked = 0;
  int accepted = 0;
  int passed_over = 0;
  StereoFrame newest;
};

// Sees one point, where the pattern of the images is.
class OnePoint final : public FrontEnd {
 public:
  OnePoint(Record& record, double step_px) : record_(record), step_px_(step_px) {}
  TrackedFrame Track(const StereoFrame& frame) override {
    record_.newest = frame;
    Observation observation;
    observation.track_id = 7;
    observation.left_pixel = {step_px_ * record_.tracked++, 0.0};
    return {frame.timestamp_ns, {observation}, {}};
  }
  void Accept(const FrameOutcome&) override { ++record_.accepted; }
  void PassOver() override { ++record_.passed_over; }

 private:
  Record& record_;
  double step_px_;
};

StereoFrame At(int64_t timestamp_ns, double left, double right) {
  return {timestamp_ns, {testing::PatternAt(left, 0.0), testing::PatternAt(right, 0.0)}};
}

class FreezeGuardTest : public ::testing::Test {
 protected:
  // Two frames of a rig that moves by so many pixels a frame.
  std::unique_ptr<FreezeGuard> Moving(double step_px, const FreezeGuardOptions& options = {}) {
    auto guard =
        std::make_unique<FreezeGuard>(std::make_unique<OnePoint>(record_, step_px), options);
    for (int i = 0; i < 2; ++i) {
      guard->Track(At(100 * i, i, i - 3.0));
      guard->Accept({});
    }
    return guard;
  }
  Record record_;
};

TEST_F(FreezeGuardTest, ImagesThatComeAgainShowNothing) {
  const std::unique_ptr<FreezeGuard> guard = Moving(5.0);
  for (int i = 2; i < 5; ++i) {
    EXPECT_TRUE(guard->Track(At(100 * i, 1.0, -2.0)).observations.empty()) << i;
    EXPECT_FALSE(guard->Retry()) << i;
    guard->Accept({.is_passed_over = true});
  }
  EXPECT_EQ(record_.tracked, 2);
  EXPECT_EQ(record_.accepted, 2);
  EXPECT_EQ(record_.passed_over, 3);
  EXPECT_EQ(guard->Track(At(500, 6.0, 3.0)).observations.size(), 1U);
}

TEST_F(FreezeGuardTest, ARigAtRestSeesTheSameAgain) {
  const std::unique_ptr<FreezeGuard> guard = Moving(0.1);
  EXPECT_EQ(guard->Track(At(200, 1.0, -2.0)).observations.size(), 1U);
}

TEST_F(FreezeGuardTest, SensorNoiseTellsTwoViewsApart) {
  const std::unique_ptr<FreezeGuard> guard = Moving(5.0);
  StereoFrame noisy = At(200, 1.0, -2.0);
  for (int row = 0; row < noisy.images[0].rows; row += 2) {
    noisy.images[0].row(row) += 1;
  }
  EXPECT_EQ(guard->Track(noisy).observations.size(), 1U);
}

TEST_F(FreezeGuardTest, AFrozenRightImageIsGivenOnAsBlack) {
  const std::unique_ptr<FreezeGuard> guard = Moving(5.0);
  EXPECT_EQ(guard->Track(At(200, 4.0, -2.0)).observations.size(), 1U);
  EXPECT_EQ(cv::countNonZero(record_.newest.images[1]), 0);
  EXPECT_GT(cv::countNonZero(record_.newest.images[0]), 0);
  guard->Accept({});
  guard->Track(At(300, 7.0, 4.0));
  EXPECT_GT(cv::countNonZero(record_.newest.images[1]), 0);
}

TEST_F(FreezeGuardTest, InTheEndEqualImagesAreRest) {
  const std::unique_ptr<FreezeGuard> guard = Moving(5.0, {.max_frozen_s = 250e-9});
  EXPECT_TRUE(guard->Track(At(200, 1.0, -2.0)).observations.empty());
  guard->Accept({.is_passed_over = true});
  EXPECT_EQ(guard->Track(At(400, 1.0, -2.0)).observations.size(), 1U);
}

TEST_F(FreezeGuardTest, OptionsAreChecked) {
  EXPECT_THROW(FreezeGuard(nullptr, {.max_difference = 0.0}), Error);
}

}  // namespace
}  // namespace gluevo::vo
