// Frames that are announced are tracked while the one before is estimated: to the same results.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "gluevo/vo/frontend/freeze_guard.h"
#include "gluevo/vo/frontend/klt_frontend.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "message_of.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kFrameNs = 100'000'000;

// Two cameras side by side before a wall that moves on by some pixels a frame.
StereoRig Rig() {
  StereoRig rig;
  for (Camera& camera : rig.cameras) {
    camera = {320, 240, 300.0, 300.0, 159.5, 119.5};
  }
  rig.body_from_cam[1].translation = {0.1, 0.0, 0.0};
  rig.body_frame = "left camera";
  return rig;
}

cv::Mat Wall() {
  constexpr int kBlock = 8;
  std::mt19937 generator(5);
  cv::Mat wall(240, 900, CV_8UC1);
  for (int y = 0; y < wall.rows; y += kBlock) {
    for (int x = 0; x < wall.cols; x += kBlock) {
      const cv::Rect block(x, y, std::min(kBlock, wall.cols - x), kBlock);
      wall(block).setTo(cv::Scalar(static_cast<double>(generator() % 256)));
    }
  }
  return wall;
}

std::vector<StereoFrame> Frames(int count) {
  const cv::Mat wall = Wall();
  std::vector<StereoFrame> frames;
  for (int i = 0; i < count; ++i) {
    StereoFrame frame{i * kFrameNs, {}};
    for (int camera = 0; camera < 2; ++camera) {
      frame.images[camera] = wall(cv::Rect(40 + 5 * i + 12 * camera, 0, 320, 240)).clone();
    }
    if (i % 10 == 7) {  // Nothing to see: passed over.
      frame.images[0].setTo(cv::Scalar(20));
    }
    frames.push_back(frame);
  }
  return frames;
}

Odometry MakeOdometry() {
  return {Rig(),
          std::make_unique<FreezeGuard>(std::make_unique<KltFrontEnd>(Rig(), KltOptions()),
                                        FreezeGuardOptions()),
          OdometryOptions()};
}

TEST(OdometryAnnounceTest, ResultsAreTheSameBitForBit) {
  const std::vector<StereoFrame> frames = Frames(60);
  Odometry plain = MakeOdometry();
  Odometry ahead = MakeOdometry();
  int passed_over = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameResult expected = plain.Process(frames[i]);
    if (i + 1 < frames.size() && i % 5 != 3) {  // Not every one is there in time.
      ahead.Announce(frames[i + 1]);
    }
    const FrameResult result = ahead.Process(frames[i]);
    EXPECT_EQ(result.world_from_body.translation, expected.world_from_body.translation) << i;
    EXPECT_EQ(result.world_from_body.rotation.coeffs(), expected.world_from_body.rotation.coeffs());
    EXPECT_EQ(result.inliers, expected.inliers);
    EXPECT_EQ(result.is_predicted, expected.is_predicted);
    EXPECT_EQ(result.segment, expected.segment);
    EXPECT_GT(result.stages_ms.at("frontend"), 0.0);
    passed_over += expected.is_predicted ? 1 : 0;
  }
  EXPECT_EQ(passed_over, 6);
}

TEST(OdometryAnnounceTest, AnotherFrameThanTheOneAnnouncedIsRefused) {
  const std::vector<StereoFrame> frames = Frames(3);
  Odometry odometry = MakeOdometry();
  odometry.Announce(frames[1]);
  odometry.Process(frames[0]);
  EXPECT_EQ(MessageOf([&] { odometry.Process(frames[2]); }),
            "the frame at 200000000 ns is not the one that was announced, at 100000000 ns");
}

TEST(OdometryAnnounceTest, WhatTrackingThrowsComesWithTheFrame) {
  std::vector<StereoFrame> frames = Frames(3);
  frames[1].images[1] = cv::Mat::zeros(10, 10, CV_8UC1);
  Odometry odometry = MakeOdometry();
  odometry.Announce(frames[1]);
  EXPECT_NO_THROW(odometry.Process(frames[0]));
  EXPECT_NE(MessageOf([&] { odometry.Process(frames[1]); }), "no error");
  EXPECT_NO_THROW(odometry.Process(frames[2]));
}

TEST(OdometryAnnounceTest, AnOdometryThatEndsWaitsForWhatItTracks) {
  const std::vector<StereoFrame> frames = Frames(3);
  Odometry odometry = MakeOdometry();
  odometry.Announce(frames[1]);
  odometry.Process(frames[0]);
  Odometry moved = std::move(odometry);
  moved.Announce(frames[2]);
  EXPECT_NO_THROW(moved.Process(frames[1]));
}

}  // namespace
}  // namespace gluevo::vo
