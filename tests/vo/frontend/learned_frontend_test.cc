#include "gluevo/vo/frontend/learned_frontend.h"

#include <gtest/gtest.h>

#include <deque>
#include <optional>
#include <set>

#include "gluevo/nn/error.h"
#include "scripted_networks.h"

namespace gluevo::vo {
namespace {

using testing::Named;
using testing::NameMatcher;
using testing::NoMatcher;
using testing::RectifiedRig;
using testing::ScriptedExtractor;

StereoFrame Frame(int64_t timestamp_ns) {
  StereoFrame frame;
  frame.timestamp_ns = timestamp_ns;
  frame.images.fill(cv::Mat::zeros(48, 64, CV_8UC1));
  return frame;
}

const Observation* At(const TrackedFrame& frame, double x, double y) {
  for (const Observation& observation : frame.observations) {
    if (observation.left_pixel == Eigen::Vector2d(x, y)) {
      return &observation;
    }
  }
  return nullptr;
}

TEST(LearnedFrontEndTest, TracksKeepTheirNumberAndStereoFollowsTheEpipolarLine) {
  LearnedFrontEnd frontend(
      RectifiedRig(),
      std::make_unique<ScriptedExtractor>(std::deque<nn::Features>{
          Named({{1, 40, 20}, {2, 30, 30}, {3, 20, 10}}),  // left
          Named({{1, 35, 20}, {2, 25, 36}, {3, 25, 10}}),  // right: 2 off its line, 3 behind
          Named({{2, 31, 30}, {4, 10, 10}, {1, 41, 20}}), Named({{1, 36, 21}})}),
      std::make_unique<NameMatcher>(), nullptr, {});
  const TrackedFrame first = frontend.Track(Frame(1));
  ASSERT_EQ(first.observations.size(), 3U);
  ASSERT_TRUE(At(first, 40, 20)->has_right);
  EXPECT_EQ(At(first, 40, 20)->right_pixel, Eigen::Vector2d(35, 20));
  EXPECT_NEAR(At(first, 40, 20)->left.x(), (40.0 - 32.0) / 50.0, 1e-12);
  EXPECT_NEAR(At(first, 40, 20)->right.x(), (35.0 - 32.0) / 50.0, 1e-12);
  EXPECT_FALSE(At(first, 30, 30)->has_right);
  EXPECT_FALSE(At(first, 20, 10)->has_right);

  const TrackedFrame second = frontend.Track(Frame(2));
  EXPECT_EQ(At(second, 41, 20)->track_id, At(first, 40, 20)->track_id);
  EXPECT_EQ(At(second, 31, 30)->track_id, At(first, 30, 30)->track_id);
  EXPECT_TRUE(At(second, 41, 20)->has_right);
  EXPECT_FLOAT_EQ(At(second, 41, 20)->tracking_confidence, 0.9F);
  std::set<int64_t> ids;
  for (const TrackedFrame* const frame : {&first, &second}) {
    for (const Observation& observation : frame->observations) {
      ids.insert(observation.track_id);
    }
  }
  EXPECT_EQ(ids.size(), 4U);
}

TEST(LearnedFrontEndTest, MinimumDistanceKeepsTheLongestTrack) {
  LearnedFrontEnd frontend(RectifiedRig(),
                           std::make_unique<ScriptedExtractor>(std::deque<nn::Features>{
                               Named({{1, 40, 20}}), Named({}),
                               Named({{5, 42, 20}, {1, 41, 20}, {6, 60, 20}}), Named({})}),
                           std::make_unique<NameMatcher>(), nullptr, {.min_distance_px = 5.0});
  frontend.Track(Frame(1));
  const TrackedFrame second = frontend.Track(Frame(2));
  EXPECT_EQ(second.observations.size(), 2U);
  EXPECT_NE(At(second, 41, 20), nullptr);
  EXPECT_NE(At(second, 60, 20), nullptr);
}

TEST(LearnedFrontEndTest, RetryMatchesByTheFallbackOnce) {
  LearnedFrontEnd frontend(RectifiedRig(),
                           std::make_unique<ScriptedExtractor>(std::deque<nn::Features>{
                               Named({{1, 40, 20}}), Named({}), Named({{1, 41, 20}}), Named({})}),
                           std::make_unique<NoMatcher>(), std::make_unique<NameMatcher>(), {});
  const TrackedFrame first = frontend.Track(Frame(1));
  const TrackedFrame lost = frontend.Track(Frame(2));
  EXPECT_NE(lost.observations[0].track_id, first.observations[0].track_id);
  const auto retried = frontend.Retry();
  ASSERT_TRUE(retried.has_value());
  EXPECT_EQ(retried->observations[0].track_id, first.observations[0].track_id);
  EXPECT_EQ(retried->timestamp_ns, 2);
  EXPECT_FALSE(frontend.Retry().has_value());
}

TEST(LearnedFrontEndTest, AFrameThatIsPassedOverIsNoReference) {
  LearnedFrontEnd frontend(RectifiedRig(),
                           std::make_unique<ScriptedExtractor>(std::deque<nn::Features>{
                               Named({{1, 40, 20}}), Named({}), Named({{7, 20, 20}}), Named({}),
                               Named({{1, 41, 20}}), Named({}), Named({{1, 42, 20}}), Named({})}),
                           std::make_unique<NameMatcher>(), nullptr, {});
  const int64_t id = frontend.Track(Frame(1)).observations[0].track_id;
  frontend.Accept({.is_keyframe = true, .starts_segment = true});
  EXPECT_NE(frontend.Track(Frame(2)).observations[0].track_id, id);
  frontend.Accept({.is_passed_over = true});
  EXPECT_EQ(frontend.Track(Frame(3)).observations[0].track_id, id);
  frontend.Accept({});
  EXPECT_EQ(frontend.Track(Frame(4)).observations[0].track_id, id);
}

// Nothing matches but by the last way: from the key frame, by the fallback.
class RecoveryTest : public ::testing::Test {
 protected:
  RecoveryTest()
      : frontend_(RectifiedRig(),
                  std::make_unique<ScriptedExtractor>(std::deque<nn::Features>{
                      Named({{1, 40, 20}}), Named({}),    // key frame
                      Named({{2, 10, 20}}), Named({}),    // sees nothing of it
                      Named({{1, 41, 20}}), Named({}),    // sees it again
                      Named({{9, 10, 10}}), Named({}),    // nothing
                      Named({{1, 42, 20}}), Named({})}),  // and again
                  std::make_unique<NoMatcher>(), std::make_unique<NameMatcher>(), {}) {
    id_ = frontend_.Track(Frame(1)).observations[0].track_id;
    frontend_.Accept({.is_keyframe = true, .starts_segment = true});
    frontend_.Track(Frame(2));
    frontend_.Accept({});
  }

  // Tracks a frame and tries all ways; the tracks that the last of them gave.
  std::optional<TrackedFrame> LastWay(int64_t timestamp_ns, int ways) {
    frontend_.Track(Frame(timestamp_ns));
    std::optional<TrackedFrame> tracked;
    for (int i = 0; i < ways; ++i) {
      tracked = frontend_.Retry();
    }
    return tracked;
  }

  LearnedFrontEnd frontend_;
  int64_t id_ = -1;
};

TEST_F(RecoveryTest, KeyFramesStayWhereTheLastWaySucceeds) {
  // From the frame before; from the key frame by the matcher, and by the fallback.
  const auto found = LastWay(3, 3);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->observations[0].track_id, id_);
  frontend_.Accept({});
  frontend_.Track(Frame(4));
  frontend_.Accept({});
  const auto again = LastWay(5, 3);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->observations[0].track_id, id_);
}

TEST_F(RecoveryTest, KeyFramesGoWhereTheEstimatorStartsAgain) {
  LastWay(3, 3);
  frontend_.Accept({.is_keyframe = false, .starts_segment = true});
  frontend_.Track(Frame(4));
  frontend_.Accept({});
  // The frame before is all that is left.
  EXPECT_FALSE(LastWay(5, 2));
}

TEST(LearnedFrontEndTest, RefusesImagesOfAnotherSizeAndBadOptions) {
  LearnedFrontEnd frontend(RectifiedRig(),
                           std::make_unique<ScriptedExtractor>(std::deque<nn::Features>{}),
                           std::make_unique<NameMatcher>(), nullptr, {});
  StereoFrame frame = Frame(1);
  frame.images[1] = cv::Mat::zeros(40, 64, CV_8UC1);
  EXPECT_THROW(frontend.Track(frame), Error);
  frame.images[1] = cv::Mat::zeros(48, 64, CV_16UC1);
  EXPECT_THROW(frontend.Track(frame), Error);
  frame.images[1] = cv::Mat::zeros(48, 64, CV_8UC3);
  EXPECT_THROW(frontend.Track(frame), Error);
  EXPECT_THROW((LearnedFrontEndOptions{.tracking_threshold = 1.0F}).Validate(), Error);
  EXPECT_THROW((LearnedFrontEndOptions{.max_epipolar_error_px = 0.0}).Validate(), Error);
  EXPECT_THROW((LearnedFrontEndOptions{.min_distance_px = -1.0}).Validate(), Error);
}

TEST(LearnedFrontEndTest, InTheBandTheNearestDescriptorOnTheEpipolarLineIsTheRightView) {
  // The left point's very own descriptor is in the right image, but off its line; what is on it
  // is less alike.
  nn::Features left = Named({{1, 30, 24}});
  nn::Features right = Named({{2, 26, 40}, {3, 26, 24}});
  left.descriptors.resize(1, 2);
  left.descriptors << 1, 0;
  right.descriptors.resize(2, 2);
  right.descriptors << 1, 0, 0.8F, 0.6F;
  LearnedFrontEndOptions options;
  options.refine = false;
  for (const bool in_band : {false, true}) {
    SCOPED_TRACE(in_band);
    options.stereo_in_band = in_band;
    LearnedFrontEnd frontend(
        RectifiedRig(), std::make_unique<ScriptedExtractor>(std::deque<nn::Features>{left, right}),
        std::make_unique<NoMatcher>(), nullptr, options);
    const TrackedFrame frame = frontend.Track(Frame(1));
    ASSERT_EQ(frame.observations.size(), 1U);
    EXPECT_EQ(frame.observations[0].has_right, in_band);
    if (in_band) {
      EXPECT_EQ(frame.observations[0].right_pixel, Eigen::Vector2d(26, 24));
      EXPECT_FLOAT_EQ(frame.observations[0].stereo_confidence, 0.8F);
    }
  }
}

}  // namespace
}  // namespace gluevo::vo
