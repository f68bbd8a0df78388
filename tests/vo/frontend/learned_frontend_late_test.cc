// Method 2 with its networks beside tracking.

#include <gtest/gtest.h>

#include <future>
#include <thread>

#include "gluevo/nn/error.h"
#include "gluevo/vo/frontend/learned_frontend.h"
#include "message_of.h"
#include "scripted_networks.h"
#include "textured_views.h"

namespace gluevo::vo {
namespace {

using testing::Named;
using testing::NameMatcher;
using testing::PatternAt;
using testing::RectifiedRig;
using testing::ScriptedExtractor;

constexpr double kStepPx = 1.1;

// The pattern, which moves on by a step a frame, three pixels nearer in the right image.
StereoFrame MovingFrame(int i) {
  const double x = kStepPx * i;
  return {i + 1, {PatternAt(x, 0), PatternAt(x - 3, 0)}};
}

LearnedFrontEndOptions LateOptions(int every, int lag) {
  LearnedFrontEndOptions options;
  options.refinement.window = 11;
  options.following.window = 11;
  options.following.levels = 1;
  options.network_every = every;
  options.network_lag = lag;
  return options;
}

std::unique_ptr<LearnedFrontEnd> LateFrontEnd(std::deque<nn::Features> script,
                                              const LearnedFrontEndOptions& options) {
  script.insert(script.end(), 4, Named({}));  // Of runs that a test begins and does not see end.
  return std::make_unique<LearnedFrontEnd>(RectifiedRig(),
                                           std::make_unique<ScriptedExtractor>(std::move(script)),
                                           std::make_unique<NameMatcher>(), nullptr, options);
}

// What the networks see of points 1 and 2 in the first frame, and of 1 and 3 in the second run's,
// which is of frame `i`. Points of 2 are lost, those of 3 new.
std::deque<nn::Features> TwoRuns(int i) {
  const auto x = static_cast<float>(std::lround(kStepPx * i));
  return {Named({{1, 30, 24}, {2, 16, 14}}), Named({{1, 27, 24}, {2, 13, 14}}),
          Named({{1, 30 + x, 24}, {3, 20 + x, 32}}), Named({{1, 27 + x, 24}, {3, 17 + x, 32}})};
}

TEST(LearnedFrontEndLateTest, WhatNetworksMadeOfAFrameIsCarriedToWhereTrackingIsByThen) {
  for (const int lag : {1, 2, 3}) {
    SCOPED_TRACE(lag);
    const auto frontend = LateFrontEnd(TwoRuns(2), LateOptions(2, lag));
    const TrackedFrame first = frontend->Track(MovingFrame(0));
    ASSERT_EQ(first.observations.size(), 2U);
    EXPECT_EQ(first.networks_age, 0);
    const int64_t one = first.observations[0].track_id;
    const int64_t two = first.observations[1].track_id;
    for (int i = 1; i < 2 + lag; ++i) {
      frontend->Accept({});
      const TrackedFrame followed = frontend->Track(MovingFrame(i));
      ASSERT_EQ(followed.observations.size(), 2U) << i;
      EXPECT_EQ(followed.observations[1].track_id, two);
      EXPECT_FALSE(followed.stages_ms.contains("features"));
      EXPECT_FALSE(followed.networks_age.has_value());
    }
    frontend->Accept({});
    const TrackedFrame taken = frontend->Track(MovingFrame(2 + lag));
    EXPECT_EQ(taken.networks_age, lag);
    EXPECT_TRUE(taken.stages_ms.contains("features"));
    ASSERT_EQ(taken.observations.size(), 2U);
    EXPECT_EQ(taken.observations[0].track_id, one);
    EXPECT_NEAR(taken.observations[0].left_pixel.x(), 30 + kStepPx * (2 + lag), 0.1);
    const Observation& three = taken.observations[1];
    EXPECT_GT(three.track_id, two);
    // A new point is where its keypoint is, on a whole pixel, and goes on from there.
    EXPECT_NEAR(three.left_pixel.x(), 20 + std::lround(kStepPx * 2) + kStepPx * lag, 0.1);
    EXPECT_NEAR(three.left_pixel.y(), 32, 0.1);
    ASSERT_TRUE(three.has_right);
    EXPECT_NEAR(three.left_pixel.x() - three.right_pixel.x(), 3, 0.1);
  }
}

TEST(LearnedFrontEndLateTest, TheNextRunBeginsAsManyFramesAfterTheLastBegan) {
  std::deque<nn::Features> script;
  for (const int i : {0, 4, 8}) {
    const auto x = static_cast<float>(std::lround(kStepPx * i));
    script.push_back(Named({{1, 30 + x, 24}}));
    script.push_back(Named({{1, 27 + x, 24}}));
  }
  const auto frontend = LateFrontEnd(std::move(script), LateOptions(4, 2));
  std::vector<int> taken;
  for (int i = 0; i <= 10; ++i) {
    if (frontend->Track(MovingFrame(i)).networks_age) {
      taken.push_back(i);
    }
    frontend->Accept({});
  }
  EXPECT_EQ(taken, (std::vector<int>{0, 6, 10}));
}

TEST(LearnedFrontEndLateTest, AFailureAsksForThemAtOnce) {
  const auto frontend = LateFrontEnd(TwoRuns(1), LateOptions(1, 3));
  const int64_t one = frontend->Track(MovingFrame(0)).observations[0].track_id;
  frontend->Accept({});
  EXPECT_FALSE(frontend->Track(MovingFrame(1)).networks_age.has_value());
  const auto retried = frontend->Retry();
  ASSERT_TRUE(retried.has_value());
  EXPECT_EQ(retried->networks_age, 0) << "they were at work on this very frame";
  ASSERT_EQ(retried->observations.size(), 2U);
  EXPECT_EQ(retried->observations[0].track_id, one);
  EXPECT_EQ(retried->observations[1].left_pixel, Eigen::Vector2d(21, 32));
  EXPECT_FALSE(frontend->Retry().has_value());
}

TEST(LearnedFrontEndLateTest, WhereFlowLosesTheTracksFramesWait) {
  std::deque<nn::Features> script = TwoRuns(1);
  script.push_back(Named({{3, 40, 20}}));
  script.push_back(Named({{3, 37, 20}}));
  const auto frontend = LateFrontEnd(std::move(script), LateOptions(1, 3));
  for (const int i : {0, 1}) {
    frontend->Track(MovingFrame(i));
    frontend->Accept({});
  }
  StereoFrame blank = MovingFrame(2);
  blank.images[0].setTo(90);
  const TrackedFrame waited = frontend->Track(blank);
  EXPECT_EQ(waited.networks_age, 0);
  // Those of the frame before were taken in first: the point that they found is matched.
  ASSERT_EQ(waited.observations.size(), 1U);
  EXPECT_GT(waited.observations[0].tracking_confidence, 0.0F);
}

TEST(LearnedFrontEndLateTest, WhereFlowKeepsHalfOfThemNetworksAreDueButFramesDoNotWait) {
  const std::vector<testing::Point> all = {{1, 14, 14}, {2, 14, 34}, {3, 50, 14}, {4, 50, 34}};
  const std::vector<testing::Point> half = {all[0], all[1]};
  const auto frontend = LateFrontEnd({Named(all), Named({}), Named(half), Named({})},
                                     LateOptions(/*every=*/100, /*lag=*/1));
  StereoFrame frame = MovingFrame(0);
  EXPECT_EQ(frontend->Track(frame).observations.size(), 4U);
  frontend->Accept({});
  ++frame.timestamp_ns;
  frame.images[0].colRange(32, 64).setTo(90);
  const TrackedFrame thin = frontend->Track(frame);
  EXPECT_FALSE(thin.networks_age.has_value());
  EXPECT_EQ(thin.observations.size(), 2U);
  frontend->Accept({});
  ++frame.timestamp_ns;
  EXPECT_EQ(frontend->Track(frame).networks_age, 1);
}

TEST(LearnedFrontEndLateTest, AFrameThatIsPassedOverIsForgotten) {
  std::deque<nn::Features> script = TwoRuns(1);
  script.push_back(Named({{1, 32, 24}}));
  script.push_back(Named({{1, 29, 24}}));
  const auto frontend = LateFrontEnd(std::move(script), LateOptions(1, 2));
  const int64_t one = frontend->Track(MovingFrame(0)).observations[0].track_id;
  frontend->Accept({});
  frontend->Track(MovingFrame(1));
  frontend->Accept({.is_passed_over = true});
  const TrackedFrame next = frontend->Track(MovingFrame(2));
  EXPECT_EQ(next.networks_age, 0);
  ASSERT_EQ(next.observations.size(), 1U);
  EXPECT_EQ(next.observations[0].track_id, one);
}

// Holds the networks up from the third image on until it is told.
class HeldExtractor final : public FeatureExtractor {
 public:
  HeldExtractor(std::deque<nn::Features> script, std::shared_future<void> released)
      : script_(std::move(script)), released_(std::move(released)) {}
  nn::Features Extract(const cv::Mat& image) override {
    if (++images_ > 2) {
      released_.wait();
    }
    return script_.Extract(image);
  }
  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& /*pixels*/) override {
    return Extract(image);
  }

 private:
  ScriptedExtractor script_;
  std::shared_future<void> released_;
  int images_ = 0;
};

TEST(LearnedFrontEndLateTest, ByTheClockTrackingGoesOnUntilTheyAreThere) {
  std::promise<void> release;
  LearnedFrontEndOptions options = LateOptions(1, 1);
  options.awaits_networks = false;
  std::deque<nn::Features> script = TwoRuns(1);
  script.insert(script.end(), 2, Named({}));  // Of the run that begins when they are taken in.
  LearnedFrontEnd frontend(
      RectifiedRig(),
      std::make_unique<HeldExtractor>(std::move(script), release.get_future().share()),
      std::make_unique<NameMatcher>(), nullptr, options);
  frontend.Track(MovingFrame(0));
  for (int i = 1; i <= 5; ++i) {
    frontend.Accept({});
    EXPECT_FALSE(frontend.Track(MovingFrame(i)).networks_age.has_value());
  }
  release.set_value();
  std::optional<int> age;
  int i = 5;
  while (!age) {
    frontend.Accept({});
    // Stands still: however long it takes, the points stay in the image.
    age = frontend.Track({++i + 1, MovingFrame(5).images}).networks_age;
    std::this_thread::yield();
  }
  EXPECT_EQ(*age, i - 1);
  EXPECT_GE(*age, 5);
}

TEST(LearnedFrontEndLateTest, WhatTheNetworksRefuseIsThrownWhereItIsTakenIn) {
  class Refusing final : public FeatureExtractor {
   public:
    nn::Features Extract(const cv::Mat& /*image*/) override {
      if (++images_ == 3) {
        throw Error("an image that the networks refuse");
      }
      return Named({{1, 30, 24}});
    }
    nn::Features Describe(const cv::Mat& image, const nn::Features::Points& /*p*/) override {
      return Extract(image);
    }

   private:
    int images_ = 0;
  };
  LearnedFrontEnd frontend(RectifiedRig(), std::make_unique<Refusing>(),
                           std::make_unique<NameMatcher>(), nullptr, LateOptions(1, 1));
  frontend.Track(MovingFrame(0));
  frontend.Accept({});
  frontend.Track(MovingFrame(1));
  frontend.Accept({});
  EXPECT_EQ(MessageOf([&] { frontend.Track(MovingFrame(2)); }),
            "an image that the networks refuse");
  EXPECT_EQ(frontend.Track(MovingFrame(2)).observations.size(), 1U);
}

}  // namespace
}  // namespace gluevo::vo
