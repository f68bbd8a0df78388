// What Method 2 does beyond the paper: points below the pixel, lost tracks found again, frames
// without networks.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gluevo/vo/frontend/learned_frontend.h"
#include "scripted_networks.h"
#include "textured_views.h"

namespace gluevo::vo {
namespace {

using testing::Named;
using testing::NameMatcher;
using testing::PatternAt;
using testing::RectifiedRig;
using testing::ScriptedExtractor;

// The pattern at (x, y) in the left image, nearer by `disparity` in the right one.
StereoFrame Frame(int64_t timestamp_ns, double x, double y, double disparity) {
  return {timestamp_ns, {PatternAt(x, y), PatternAt(x - disparity, y)}};
}

std::unique_ptr<LearnedFrontEnd> FrontEndWith(std::deque<nn::Features> script,
                                              const LearnedFrontEndOptions& options,
                                              std::unique_ptr<Matcher> fallback = nullptr) {
  return std::make_unique<LearnedFrontEnd>(
      RectifiedRig(), std::make_unique<ScriptedExtractor>(std::move(script)),
      std::make_unique<NameMatcher>(), std::move(fallback), options);
}

LearnedFrontEndOptions SmallWindows(LearnedFrontEndOptions options) {
  options.refinement.window = 11;
  options.following.window = 11;
  options.following.levels = 1;
  return options;
}

const Observation& Only(const TrackedFrame& frame) {
  EXPECT_EQ(frame.observations.size(), 1U);
  return frame.observations.front();
}

TEST(LearnedFrontEndFlowTest, MatchedPointsFollowTheSamePlaceBelowThePixel) {
  const auto frontend =
      FrontEndWith({Named({{1, 30, 24}}), Named({{1, 27, 24}}), Named({{1, 32, 25}}),
                    Named({{1, 28, 25}}), Named({{1, 33, 24}}), Named({{1, 29, 25}})},
                   SmallWindows({.network_every = 1}));
  const Observation first = Only(frontend->Track(Frame(1, 0, 0, 3.3)));
  EXPECT_EQ(first.left_pixel, Eigen::Vector2d(30, 24));
  EXPECT_NEAR(first.right_pixel.x(), 26.7, 0.05);
  const Observation second = Only(frontend->Track(Frame(2, 1.4, 0.7, 3.3)));
  EXPECT_EQ(second.track_id, first.track_id);
  EXPECT_NEAR(second.left_pixel.x(), 31.4, 0.05);
  EXPECT_NEAR(second.left_pixel.y(), 24.7, 0.05);
  EXPECT_NEAR(second.right_pixel.x(), 28.1, 0.05);
  const Observation third = Only(frontend->Track(Frame(3, 2.8, 0.2, 3.3)));
  EXPECT_NEAR(third.left_pixel.x(), 32.8, 0.1);
  EXPECT_NEAR(third.left_pixel.y(), 24.2, 0.1);
}

// A checkerboard's corner at (x, y), where four fields meet.
cv::Mat CornerAt(double x, double y) {
  cv::Mat image(48, 64, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double right = std::clamp(u - x, -1.0, 1.0);
      const double below = std::clamp(v - y, -1.0, 1.0);
      image.at<uint8_t>(v, u) = static_cast<uint8_t>(std::lround(128.0 + 90.0 * right * below));
    }
  }
  return image;
}

TEST(LearnedFrontEndFlowTest, TracksBeginAtCornersWhereFlowConfirmsMatches) {
  for (const bool at_corners : {false, true}) {
    SCOPED_TRACE(at_corners);
    // 2 lies beside the corner, on the last frame elsewhere.
    const auto frontend =
        FrontEndWith({Named({{1, 30, 24}}), Named({{1, 27, 24}}), Named({{1, 31, 24}, {2, 33, 22}}),
                      Named({{1, 28, 24}, {2, 30, 22}}), Named({{1, 32, 24}, {2, 34, 23}}),
                      Named({{1, 29, 24}, {2, 31, 23}})},
                     SmallWindows({.begin_at_corners = at_corners, .network_every = 1}));
    const auto frame = [](int64_t stamp, double x) -> StereoFrame {
      return {stamp, {CornerAt(x, 23.7), CornerAt(x - 3, 23.7)}};
    };
    frontend->Track(frame(1, 30.4));
    const TrackedFrame second = frontend->Track(frame(2, 31.4));
    ASSERT_EQ(second.observations.size(), 2U);
    const Observation& first = second.observations[1];
    const Eigen::Vector2d begin =
        at_corners ? Eigen::Vector2d(31.4, 23.7) : Eigen::Vector2d(33, 22);
    EXPECT_LT((first.left_pixel - begin).norm(), 0.1);
    EXPECT_LT((first.right_pixel - begin - Eigen::Vector2d(-3, 0)).norm(), 0.15);
    // A track that is carried on does not begin anew.
    const TrackedFrame third = frontend->Track(frame(3, 32.4));
    ASSERT_EQ(third.observations.size(), 2U);
    EXPECT_EQ(third.observations[1].track_id, first.track_id);
    EXPECT_LT((third.observations[1].left_pixel - begin - Eigen::Vector2d(1, 0)).norm(), 0.15);
  }
}

TEST(LearnedFrontEndFlowTest, WhereFlowSeesSomethingElseTheMatchCounts) {
  const auto frontend = FrontEndWith(
      {Named({{1, 30, 24}}), Named({}), Named({{1, 40, 24}}), Named({})}, SmallWindows({}));
  frontend->Track(Frame(1, 0, 0, 0));
  StereoFrame frame = Frame(2, 0, 0, 0);
  frame.images[0].setTo(90);
  EXPECT_EQ(Only(frontend->Track(frame)).left_pixel, Eigen::Vector2d(40, 24));
}

TEST(LearnedFrontEndFlowTest, WhatFlowDoesNotConfirmIsDroppedWhereItConfirmsMost) {
  for (const double share : {0.4, 0.6}) {
    SCOPED_TRACE(share);
    // 1 moves as the pattern does, 2 jumps; in both left images and from left to right.
    const auto frontend =
        FrontEndWith({Named({{1, 30, 24}, {2, 20, 14}}), Named({{1, 27, 24}, {2, 5, 14}}),
                      Named({{1, 31, 24}, {2, 40, 34}}), Named({{1, 28, 24}, {2, 25, 34}})},
                     SmallWindows({.min_confirmed_share = share, .network_every = 1}));
    const TrackedFrame first = frontend->Track(Frame(1, 0, 0, 3));
    const TrackedFrame second = frontend->Track(Frame(2, 1, 0, 3));
    ASSERT_EQ(first.observations.size(), 2U);
    ASSERT_EQ(second.observations.size(), 2U);
    EXPECT_EQ(second.observations[0].track_id, first.observations[0].track_id);
    EXPECT_EQ(second.observations[1].left_pixel, Eigen::Vector2d(40, 34));
    const bool kept = share > 0.5;
    EXPECT_EQ(second.observations[1].track_id == first.observations[1].track_id, kept);
    EXPECT_EQ(second.observations[1].tracking_confidence > 0.0F, kept);
    EXPECT_EQ(second.observations[1].has_right, kept);
    EXPECT_EQ(first.observations[1].has_right, kept);
  }
}

TEST(LearnedFrontEndFlowTest, TheLastKeyframeGivesLostTracksBack) {
  for (const bool rematch : {false, true}) {
    SCOPED_TRACE(rematch);
    const auto frontend = FrontEndWith(
        {Named({{1, 30, 24}}), Named({}), Named({}), Named({}), Named({{1, 31, 24}}), Named({})},
        SmallWindows({.rematch_keyframe = rematch, .network_every = 1}));
    const Observation first = Only(frontend->Track(Frame(1, 0, 0, 0)));
    frontend->Accept({.is_keyframe = true});
    EXPECT_TRUE(frontend->Track(Frame(2, 0, 0, 0)).observations.empty());
    frontend->Accept({});
    const Observation third = Only(frontend->Track(Frame(3, 1.2, 0, 0)));
    EXPECT_EQ(third.track_id == first.track_id, rematch);
    if (rematch) {
      EXPECT_NEAR(third.left_pixel.x(), 31.2, 0.05);
    }
  }
}

TEST(LearnedFrontEndFlowTest, RetryTriesKeyframesTheNewestFirst) {
  const auto frontend = FrontEndWith(
      {Named({{1, 30, 24}}), Named({}), Named({{2, 20, 20}}), Named({}), Named({}), Named({}),
       Named({{1, 30, 24}, {2, 20, 20}}), Named({}), Named({{1, 30, 24}}), Named({})},
      SmallWindows({.recovery_keyframes = 5, .network_every = 1}),
      std::make_unique<testing::NoMatcher>());
  const int64_t one = Only(frontend->Track(Frame(1, 0, 0, 0))).track_id;
  frontend->Accept({.is_keyframe = true});
  const int64_t two = Only(frontend->Track(Frame(2, 0, 0, 0))).track_id;
  frontend->Accept({.is_keyframe = true});
  frontend->Track(Frame(3, 0, 0, 0));
  frontend->Accept({});
  const auto has = [](const TrackedFrame& frame, int64_t track) {
    return std::any_of(frame.observations.begin(), frame.observations.end(),
                       [&](const Observation& o) { return o.track_id == track; });
  };
  TrackedFrame tried = frontend->Track(Frame(4, 0, 0, 0));
  EXPECT_FALSE(has(tried, one) || has(tried, two));
  // The fallback from the previous frame; matcher and fallback from the two key frames.
  const std::pair<bool, bool> expected[] = {
      {false, false}, {false, true}, {false, false}, {true, false}, {false, false}};
  for (const auto& [has_one, has_two] : expected) {
    const auto retried = frontend->Retry();
    ASSERT_TRUE(retried.has_value());
    EXPECT_EQ(retried->observations.size(), 2U);
    EXPECT_EQ(has(*retried, one), has_one);
    EXPECT_EQ(has(*retried, two), has_two);
  }
  EXPECT_FALSE(frontend->Retry().has_value());
  // Nothing helped, the estimator starts again: old key frames are of no use to it.
  frontend->Accept({.is_keyframe = true, .starts_segment = true});
  frontend->Track(Frame(5, 0, 0, 0));
  ASSERT_TRUE(frontend->Retry().has_value());
  EXPECT_FALSE(frontend->Retry().has_value());
}

TEST(LearnedFrontEndFlowTest, OpticalFlowCarriesTracksBetweenNetworkFrames) {
  const auto frontend =
      FrontEndWith({Named({{1, 30, 24}}), Named({{1, 27, 24}}), Named({{1, 33, 24}}),
                    Named({{1, 30, 24}}), Named({{1, 33, 24}}), Named({{1, 30, 24}})},
                   SmallWindows({.network_every = 3}));
  const Observation first = Only(frontend->Track(Frame(1, 0, 0, 3)));
  frontend->Accept({});
  for (int i = 1; i <= 2; ++i) {
    const TrackedFrame followed = frontend->Track(Frame(1 + i, 1.1 * i, 0, 3));
    // A key frame that the networks have not seen serves as any other.
    frontend->Accept({.is_keyframe = i == 1});
    EXPECT_FALSE(followed.stages_ms.contains("features"));
    EXPECT_EQ(Only(followed).track_id, first.track_id);
    EXPECT_NEAR(Only(followed).left_pixel.x(), 30 + 1.1 * i, 0.1);
    EXPECT_NEAR(Only(followed).right_pixel.x(), 27 + 1.1 * i, 0.1);
    EXPECT_GT(Only(followed).stereo_confidence, 0.0F);
  }
  const TrackedFrame matched = frontend->Track(Frame(4, 3.3, 0, 3));
  EXPECT_TRUE(matched.stages_ms.contains("features"));
  EXPECT_EQ(Only(matched).track_id, first.track_id);
  EXPECT_NEAR(Only(matched).left_pixel.x(), 33.3, 0.1);
  // A failure asks for them.
  frontend->Accept({});
  EXPECT_FALSE(frontend->Track(Frame(5, 3.3, 0, 3)).stages_ms.contains("features"));
  const auto retried = frontend->Retry();
  ASSERT_TRUE(retried.has_value());
  EXPECT_TRUE(retried->stages_ms.contains("features"));
  EXPECT_EQ(Only(*retried).track_id, first.track_id);
}

TEST(LearnedFrontEndFlowTest, WhatIsBehindAFollowedPointDoesNotDrawIt) {
  LearnedFrontEndOptions options;
  options.refinement.window = 7;
  options.following.window = 21;
  options.following.levels = 1;
  const auto frontend = FrontEndWith({Named({{1, 30, 24}}), Named({{1, 30, 24}})}, options);
  // A small thing over a background that stays.
  const auto moved = [](int64_t timestamp_ns, int x) {
    StereoFrame frame = Frame(timestamp_ns, 0, 0, 0);
    const cv::Rect before(24, 18, 13, 13);
    const cv::Mat thing = PatternAt(3, 5)(before);
    for (cv::Mat& image : frame.images) {
      thing.copyTo(image(before + cv::Point(x, 0)));
    }
    return frame;
  };
  frontend->Track(moved(1, 0));
  frontend->Accept({});
  const TrackedFrame followed = frontend->Track(moved(2, 1));
  EXPECT_FALSE(followed.stages_ms.contains("features"));
  EXPECT_NEAR(Only(followed).left_pixel.x(), 31, 0.02);
  EXPECT_NEAR(Only(followed).left_pixel.y(), 24, 0.02);
}

TEST(LearnedFrontEndFlowTest, NetworksRunWhereFlowLosesTheTracks) {
  const auto frontend =
      FrontEndWith({Named({{1, 30, 24}}), Named({}), Named({{1, 30, 24}}), Named({})},
                   SmallWindows({.network_every = 100}));
  frontend->Track(Frame(1, 0, 0, 0));
  StereoFrame frame = Frame(2, 0, 0, 0);
  frame.images[0].setTo(90);
  EXPECT_TRUE(frontend->Track(frame).stages_ms.contains("features"));
}

TEST(LearnedFrontEndFlowTest, PointsWithoutARayAreLeftOut) {
  StereoRig rig = RectifiedRig();
  for (Camera& camera : rig.cameras) {
    camera.fx = camera.fy = 15.0;
    camera.distortion = Distortion::kEquidistant;
  }
  ASSERT_FALSE(rig.cameras[0].Undistort({1, 1}).allFinite());
  const auto described = [](nn::Features features) {
    features.descriptors.setOnes(features.size(), 2);
    return features;
  };
  LearnedFrontEnd frontend(
      rig,
      std::make_unique<ScriptedExtractor>(std::deque<nn::Features>{
          described(Named({{1, 1, 1}, {2, 30, 24}})), described(Named({{1, 1, 1}, {2, 29, 24}}))}),
      std::make_unique<NameMatcher>(), nullptr, {.refine = false});
  const Observation observation = Only(frontend.Track(Frame(1, 0, 0, 0)));
  EXPECT_EQ(observation.left_pixel, Eigen::Vector2d(30, 24));
  EXPECT_TRUE(observation.has_right);
}

}  // namespace
}  // namespace gluevo::vo
