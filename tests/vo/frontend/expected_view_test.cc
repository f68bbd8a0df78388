// What front ends make of what an inertial unit says of the next image.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/expected_view.h"
#include "gluevo/vo/frontend/freeze_guard.h"
#include "gluevo/vo/frontend/klt_frontend.h"
#include "gluevo/vo/frontend/optical_flow.h"
#include "scripted_networks.h"
#include "textured_views.h"

namespace gluevo::vo {
namespace {

constexpr double kFar = 100.0;  // Metres: no parallax.

StereoRig LargerRig() {
  StereoRig rig = testing::RectifiedRig();
  for (Camera& camera : rig.cameras) {
    camera = {.width = 320, .height = 240, .fx = 250.0, .fy = 250.0, .cx = 160.0, .cy = 120.0};
  }
  return rig;
}

// Blobs all over the sphere, none like another near by: what a camera sees that looks along
// `world_from_cam`'s z.
cv::Mat SkySeenBy(const Camera& camera, const Eigen::Quaterniond& world_from_cam) {
  const auto noise = [](int x, int y) {
    auto hash = static_cast<unsigned>(x * 73856093) ^ static_cast<unsigned>(y * 19349663);
    hash = (hash ^ (hash >> 13U)) * 1274126177U;
    return static_cast<double>((hash ^ (hash >> 16U)) & 255U);
  };
  cv::Mat image(camera.height, camera.width, CV_8UC1);
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      const Eigen::Vector2d ray = camera.Undistort({column, row});
      const Eigen::Vector3d seen = world_from_cam * ray.homogeneous();
      // On a grid of the plane z = 1 of the world, with smooth transitions.
      const double u = 30.0 * seen.x() / seen.z() + 500.0;
      const double v = 30.0 * seen.y() / seen.z() + 500.0;
      const int x = static_cast<int>(u);
      const int y = static_cast<int>(v);
      const auto smooth = [](double t) { return t * t * (3.0 - 2.0 * t); };
      const double s = smooth(u - x);
      const double t = smooth(v - y);
      const double value = (1.0 - s) * (1.0 - t) * noise(x, y) + s * (1.0 - t) * noise(x + 1, y) +
                           (1.0 - s) * t * noise(x, y + 1) + s * t * noise(x + 1, y + 1);
      image.at<unsigned char>(row, column) = static_cast<unsigned char>(std::lround(value));
    }
  }
  return image;
}

Eigen::Quaterniond Turn(double degrees, const Eigen::Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(degrees * M_PI / 180.0, axis.normalized()));
}

StereoFrame Seen(const StereoRig& rig, int64_t timestamp_ns,
                 const Eigen::Quaterniond& world_from_cam) {
  const cv::Mat image = SkySeenBy(rig.cameras[0], world_from_cam);
  return {timestamp_ns, {image, image}};
}

// Tracks of the first frame that the second has within a pixel of where they are.
int CountRight(const TrackedFrame& first, const TrackedFrame& second, const Camera& camera,
               const Eigen::Quaterniond& second_from_first) {
  std::map<int64_t, Eigen::Vector2d> rays;
  for (const Observation& observation : first.observations) {
    rays[observation.track_id] = observation.left;
  }
  int right = 0;
  for (const Observation& observation : second.observations) {
    const auto found = rays.find(observation.track_id);
    if (found != rays.end()) {
      const Eigen::Vector2d truth = camera.Project(second_from_first * found->second.homogeneous());
      right += (truth - observation.left_pixel).norm() < 1.0 ? 1 : 0;
    }
  }
  return right;
}

class ExpectedViewTest : public ::testing::Test {
 protected:
  // The tracks that are found again after a turn of the camera, with what it is said to be.
  int FoundAfter(const Eigen::Quaterniond& world_from_second, const ExpectedView* view) {
    const StereoRig rig = LargerRig();
    KltFrontEnd frontend(rig, {.min_distance = 12});
    const TrackedFrame first = frontend.Track(Seen(rig, 1, Eigen::Quaterniond::Identity()));
    frontend.Accept({});
    if (view != nullptr) {
      frontend.Expect(*view);
    }
    const TrackedFrame second = frontend.Track(Seen(rig, 2, world_from_second));
    return CountRight(first, second, rig.cameras[0], world_from_second.conjugate());
  }
};

TEST_F(ExpectedViewTest, KltFindsTracksOfACameraThatTurnedFar) {
  const Eigen::Quaterniond turned = Turn(50.0, {0.1, 0.2, 1.0});
  ExpectedView view;
  // A few degrees off.
  view.now_from_last = (turned * Turn(2.0, {1.0, 0.0, 1.0})).conjugate();
  EXPECT_LT(FoundAfter(turned, nullptr), 5);
  EXPECT_GT(FoundAfter(turned, &view), 40);
}

TEST_F(ExpectedViewTest, KltSeeksKnownPointsWhereTheyWillBe) {
  const Eigen::Quaterniond turned = Turn(7.0, {1.0, 1.0, 0.0});
  const StereoRig rig = LargerRig();
  // One level: larger steps than the patch are not found by themselves.
  const KltOptions options = {.min_distance = 12, .window = 15, .levels = 0};
  for (const bool is_told : {false, true}) {
    KltFrontEnd frontend(rig, options);
    const TrackedFrame first = frontend.Track(Seen(rig, 1, Eigen::Quaterniond::Identity()));
    frontend.Accept({});
    ExpectedView view;
    view.now_from_last = turned.conjugate();
    for (std::size_t i = 0; i < first.observations.size(); i += 2) {
      const Observation& observation = first.observations[i];
      const Eigen::Vector2d there = rig.cameras[0].Project(
          turned.conjugate() * Eigen::Vector3d(kFar * observation.left.homogeneous()));
      view.pixels[observation.track_id] = there + Eigen::Vector2d(1.5, -1.0);
    }
    if (is_told) {
      frontend.Expect(view);
    }
    const TrackedFrame second = frontend.Track(Seen(rig, 2, turned));
    const int right = CountRight(first, second, rig.cameras[0], turned.conjugate());
    // Of the unknown ones, too.
    EXPECT_TRUE(is_told ? right > static_cast<int>(view.pixels.size()) : right < 10) << right;
  }
}

TEST_F(ExpectedViewTest, WhatWasWronglyExpectedIsForgottenWhenItFails) {
  const StereoRig rig = LargerRig();
  const StereoFrame before = Seen(rig, 1, Eigen::Quaterniond::Identity());
  const Eigen::Quaterniond turned = Turn(1.0, {0.0, 1.0, 0.0});
  const StereoFrame after = Seen(rig, 2, turned);
  KltFrontEnd told(rig, {.min_distance = 12});
  KltFrontEnd alone(rig, {.min_distance = 12});
  told.Track(before);
  alone.Track(before);
  told.Accept({});
  alone.Accept({});
  told.Expect({.now_from_last = Turn(60.0, {0.0, 0.0, 1.0}), .pixels = {}});
  told.Track(after);
  const TrackedFrame by_itself = alone.Track(after);
  EXPECT_FALSE(alone.Retry());
  ASSERT_TRUE(told.Retry());  // By descriptors.
  const auto last = told.Retry();
  ASSERT_TRUE(last);
  EXPECT_FALSE(told.Retry());
  // Numbers of new tracks differ.
  const TrackedFrame first = alone.Track(before);
  std::map<int64_t, Eigen::Vector2d> pixels;
  for (const Observation& observation : last->observations) {
    pixels[observation.track_id] = observation.left_pixel;
  }
  int same = 0;
  for (const Observation& observation : by_itself.observations) {
    if (observation.tracking_confidence > 0.0F) {
      ASSERT_TRUE(pixels.contains(observation.track_id));
      EXPECT_EQ(pixels[observation.track_id], observation.left_pixel);
      ++same;
    }
  }
  EXPECT_GT(same, 20);
}

TEST_F(ExpectedViewTest, WhatWasExpectedOfARefusedImageIsForgotten) {
  const StereoRig rig = LargerRig();
  const StereoFrame before = Seen(rig, 1, Eigen::Quaterniond::Identity());
  const StereoFrame after = Seen(rig, 2, Turn(1.0, {0.0, 1.0, 0.0}));
  KltFrontEnd told(rig, {.min_distance = 12});
  KltFrontEnd alone(rig, {.min_distance = 12});
  for (KltFrontEnd* const frontend : {&told, &alone}) {
    frontend->Track(before);
    frontend->Accept({});
  }
  told.Expect({.now_from_last = Turn(60.0, {0.0, 0.0, 1.0}), .pixels = {}});
  EXPECT_THROW(told.Track({2, {cv::Mat(), cv::Mat()}}), Error);
  const TrackedFrame there = told.Track(after);
  const TrackedFrame here = alone.Track(after);
  ASSERT_EQ(there.observations.size(), here.observations.size());
  for (std::size_t i = 0; i < here.observations.size(); ++i) {
    EXPECT_EQ(there.observations[i].left_pixel, here.observations[i].left_pixel);
  }
}

// Keeps what it is told.
class Told final : public FrontEnd {
 public:
  explicit Told(std::vector<int64_t>& expected) : expected_(expected) {}
  void Expect(const ExpectedView& view) override {
    expected_.push_back(view.pixels.begin()->first);
  }
  TrackedFrame Track(const StereoFrame& frame) override {
    Observation observation;
    observation.left_pixel = {5.0 * static_cast<double>(frame.timestamp_ns), 0.0};
    return {frame.timestamp_ns, {observation}, {}};
  }

 private:
  std::vector<int64_t>& expected_;
};

TEST(ExpectedViewOfFreezeGuardTest, IsThatOfTheFrameThatIsGivenOn) {
  std::vector<int64_t> expected;
  FreezeGuard guard(std::make_unique<Told>(expected), {});
  const auto track = [&](int64_t timestamp_ns, double shift, bool is_expected) {
    if (is_expected) {
      guard.Expect({Eigen::Quaterniond::Identity(), {{timestamp_ns, {1.0, 2.0}}}});
    }
    const cv::Mat image = testing::PatternAt(shift, 0.0);
    guard.Track({timestamp_ns, {image, testing::PatternAt(shift - 3.0, 0.0)}});
    guard.Accept({});
  };
  track(1, 0.0, false);
  track(2, 5.0, true);
  track(3, 5.0, true);  // The same image again: it is not given on, nor is what was expected.
  track(4, 9.0, false);
  track(5, 14.0, true);
  EXPECT_EQ(expected, (std::vector<int64_t>{2, 5}));
}

TEST(FollowFinelyTest, LosesWhatTheSmallPatchFindsElsewhere) {
  const Pyramid from = MakePyramid(testing::PatternAt(0.0, 0.0), 9, 0);
  const Pyramid to = MakePyramid(testing::PatternAt(1.3, 0.0), 9, 0);
  const std::vector<cv::Point2f> pixels = {{20.0F, 20.0F}, {40.0F, 20.0F}, {30.0F, 30.0F}};
  const FlowOptions small = {.window = 7, .levels = 0, .levels_back = 0};
  Flow coarse{{{21.0F, 20.2F}, {39.2F, 20.0F}, {31.3F, 30.0F}}, {1, 1, 0}};
  const Flow fine = FollowFinely(from, to, pixels, coarse, small, 1.0);
  EXPECT_TRUE(fine.found[0]);
  EXPECT_NEAR(fine.pixels[0].x, 21.3, 0.05);
  EXPECT_FALSE(fine.found[1]);  // Too far from where the large one ended,
  EXPECT_FALSE(fine.found[2]);  // not found by it.
}

}  // namespace
}  // namespace gluevo::vo
