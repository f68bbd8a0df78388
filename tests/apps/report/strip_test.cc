#include "strip.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

namespace gluevo::apps {
namespace {

vo::StereoFrame Frame(int gray) {
  vo::StereoFrame frame;
  frame.images[0] = cv::Mat(100, 960, CV_8UC1, cv::Scalar(gray));
  frame.images[1] = cv::Mat(100, 960, CV_8UC1, cv::Scalar(255 - gray));
  return frame;
}

// Track 0 moves by 3 pixels a frame and has a match 10 pixels to the left; each frame has a track
// of its own besides.
vo::FrameResult Result(int index, int segment = 0) {
  vo::FrameResult result;
  result.timestamp_ns = index * 100'000'000LL;
  result.segment = segment;
  vo::Observation moving;
  moving.left_pixel = {50.0 + 3.0 * index, 20.0};
  moving.has_right = true;
  moving.right_pixel = moving.left_pixel - Eigen::Vector2d(10.0, 0.0);
  vo::Observation own;
  own.track_id = 1000 + index;
  own.left_pixel = {5.0, 5.0};
  result.tracked_frame.observations = {moving, own};
  return result;
}

TEST(StripRecorderTest, KeepsFewFramesSpreadOverTheRun) {
  for (const std::size_t count : {0U, 1U, 3U, 8U, 9U, 51U, 1000U}) {
    SCOPED_TRACE(count);
    StripRecorder recorder(count);
    for (std::size_t i = 0; i < count; ++i) {
      recorder.Add(Result(static_cast<int>(i)), [] { return Frame(100); });
    }
    const std::vector<StripFrame>& frames = recorder.frames();
    ASSERT_EQ(frames.size(), std::min<std::size_t>(count, 8));
    for (std::size_t i = 0; i < frames.size(); ++i) {
      // One in each of as many equal stretches.
      EXPECT_EQ(frames[i].index * frames.size() / count, i);
    }
  }
}

TEST(StripRecorderTest, OfARunWithoutAKnownEndItKeepsNoMoreEither) {
  StripRecorder recorder(0);
  for (int i = 0; i < 1000; ++i) {
    // Lost at 6 frames; what is kept are the first 4.
    recorder.Add(Result(i, i / 150), [] { return Frame(100); });
    if (i > 16) {
      ASSERT_GE(recorder.frames().size(), 8U) << i;
      ASSERT_LE(recorder.frames().size(), 16U + 4U) << i;
    }
  }
  std::vector<std::size_t> even;
  std::vector<std::size_t> resets;
  for (const StripFrame& frame : recorder.frames()) {
    (frame.is_reset ? resets : even).push_back(frame.index);
  }
  EXPECT_EQ(resets, (std::vector<std::size_t>{150, 300, 450, 600}));
  for (std::size_t i = 0; i < even.size(); ++i) {
    EXPECT_EQ(even[i], i * even[1]) << "spread evenly";
  }
  EXPECT_GT(even.back(), 1000U - 2 * even[1]);
}

TEST(StripRecorderTest, ShowsMotionNewTracksAndStereo) {
  StripRecorder recorder(8);
  for (int i = 0; i < 8; ++i) {
    recorder.Add(Result(i), [] { return Frame(100); });
  }
  const StripFrame& first = recorder.frames()[0];
  EXPECT_TRUE(first.tracked.empty());
  EXPECT_EQ(first.new_points.size(), 2U);
  const StripFrame& frame = recorder.frames()[5];
  EXPECT_EQ(frame.timestamp_ns, 500'000'000);
  EXPECT_EQ(frame.width, 960);
  ASSERT_EQ(frame.tracked.size(), 1U);
  EXPECT_EQ(frame.tracked[0].from.x(), 62.0F);
  EXPECT_EQ(frame.tracked[0].to.x(), 65.0F);
  ASSERT_EQ(frame.new_points.size(), 1U);
  EXPECT_EQ(frame.new_points[0].x(), 5.0F);
  ASSERT_EQ(frame.stereo.size(), 1U);
  EXPECT_EQ(frame.stereo[0].to.x(), 55.0F);
  const cv::Mat left = cv::imdecode(frame.left_jpeg, cv::IMREAD_GRAYSCALE);
  const cv::Mat right = cv::imdecode(frame.right_jpeg, cv::IMREAD_GRAYSCALE);
  EXPECT_LE(left.cols, 480) << "small";
  EXPECT_EQ(left.rows * 960, left.cols * 100);
  EXPECT_NEAR(left.at<uint8_t>(9, 9), 100, 3);
  EXPECT_NEAR(right.at<uint8_t>(9, 9), 155, 3);

  const std::string html = DrawStrip(recorder.frames(), 0);
  // Pixel (62, 20) of 960 x 100 in a drawing 440 wide, whose pixels begin at the corner.
  EXPECT_NE(html.find("M28.6 9.4L30 9.4"), std::string::npos);
}

TEST(StripRecorderTest, KeepsTheFirstFramesThatLostTracking) {
  StripRecorder recorder(100);
  for (int i = 0; i < 100; ++i) {
    recorder.Add(Result(i, i / 10), [] { return Frame(100); });
  }
  std::vector<std::size_t> resets;
  for (const StripFrame& frame : recorder.frames()) {
    if (frame.is_reset) {
      resets.push_back(frame.index);
    }
  }
  EXPECT_EQ(resets, (std::vector<std::size_t>{10, 20, 30, 40}));
  EXPECT_LE(recorder.frames().size(), 12U);
}

}  // namespace
}  // namespace gluevo::apps
