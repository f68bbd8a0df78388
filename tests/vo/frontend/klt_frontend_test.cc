#include "gluevo/vo/frontend/klt_frontend.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "gluevo/nn/error.h"
#include "scripted_networks.h"
#include "textured_views.h"

namespace gluevo::vo {
namespace {

constexpr KltOptions kSmall = {.min_distance = 8, .window = 9, .levels = 1};

// The right image shows the left one's pattern `shift_px` farther right.
StereoFrame Frame(int64_t timestamp_ns, double shift_px) {
  return {timestamp_ns, {testing::PatternAt(0.0, 0.0), testing::PatternAt(shift_px, 0.0)}};
}

long CountStereo(const TrackedFrame& frame) {
  return std::count_if(frame.observations.begin(), frame.observations.end(),
                       [](const Observation& observation) { return observation.has_right; });
}

TEST(KltFrontEndTest, RightViewsLieInFrontOfTheCameras) {
  KltFrontEnd in_front(testing::RectifiedRig(), kSmall);
  EXPECT_GT(CountStereo(in_front.Track(Frame(1, -3.0))), 5);
  KltFrontEnd behind(testing::RectifiedRig(), kSmall);
  EXPECT_EQ(CountStereo(behind.Track(Frame(1, 3.0))), 0);
}

TEST(KltFrontEndTest, AFrameThatIsPassedOverIsAsIfItHadNotBeen) {
  const auto at = [](int64_t timestamp_ns, double x) {
    return StereoFrame{timestamp_ns,
                       {testing::PatternAt(x, 0.0), testing::PatternAt(x - 3.0, 0.0)}};
  };
  KltFrontEnd frontend(testing::RectifiedRig(), kSmall);
  frontend.Track(at(1, 0.0));
  frontend.Accept({});
  const TrackedFrame before = frontend.Track(at(2, 1.0));
  frontend.Accept({});
  const cv::Mat black = cv::Mat::zeros(48, 64, CV_8UC1);
  frontend.Track({3, {black, black}});
  frontend.Accept({.is_passed_over = true});
  // Twice the motion since the frame that it is matched with.
  const TrackedFrame after = frontend.Track(at(4, 3.0));
  int found = 0;
  for (const Observation& observation : after.observations) {
    for (const Observation& old : before.observations) {
      if (old.track_id == observation.track_id) {
        EXPECT_NEAR(observation.left_pixel.x() - old.left_pixel.x(), 2.0, 0.2);
        ++found;
      }
    }
  }
  EXPECT_GT(found, 5);
}

TEST(KltFrontEndTest, ARefusedImageChangesNothing) {
  KltFrontEnd frontend(testing::RectifiedRig(), kSmall);
  const TrackedFrame first = frontend.Track(Frame(1, -3.0));
  const cv::Mat wrong_ones[] = {cv::Mat::zeros(40, 64, CV_8UC1), cv::Mat::zeros(48, 64, CV_8UC3),
                                cv::Mat()};
  for (const cv::Mat& wrong : wrong_ones) {
    StereoFrame bad = Frame(2, -3.0);
    bad.images[1] = wrong;
    EXPECT_THROW(frontend.Track(bad), Error);
  }
  const TrackedFrame second = frontend.Track(Frame(3, -3.0));
  ASSERT_EQ(second.observations.size(), first.observations.size());
  EXPECT_EQ(second.observations[0].track_id, first.observations[0].track_id);
}

}  // namespace
}  // namespace gluevo::vo
