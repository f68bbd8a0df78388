#include "frame_log.h"

#include <gtest/gtest.h>

#include "file_size_limit.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace gluevo::apps {
namespace {

vo::FrameResult Frame(int i) {
  const double x = i;
  vo::FrameResult frame;
  frame.timestamp_ns = 1'403'715'278'062'142'976 + i;
  frame.world_from_body = {Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {1.0 / 3.0, x, -x}};
  frame.is_keyframe = i % 2 == 0;
  frame.segment = i;
  frame.is_predicted = i % 3 == 0;
  frame.is_bridged = i % 5 == 0;
  frame.keyframe_from_body.translation = {0.1 * x, 0.0, 1e-300};
  frame.motion_from_ns = i - 1;
  frame.motion_covariance.setConstant(0.1 * i);
  frame.path_covariance.setIdentity();
  frame.matched = 7 * i;
  frame.landmarks = 1000 + i;
  frame.refused_speed_m_per_s = 0.7;
  frame.stages_ms = {{"estimator", 0.1 * i}, {i % 3 == 0 ? "flow" : "networks_wait", 2.0}};
  if (i % 2 == 1) {
    frame.inertial.emplace();
    frame.inertial->gravity_in_world = {0.0, -9.8, 0.1 * x};
    frame.inertial->bias.accelerometer = {x, 0.0, 0.5};
    if (i % 4 == 1) {
      frame.inertial->time_offset_s = 0.001 * i;
    }
    frame.inertial->time_offset_sigma_s = 1e-4;
  }
  return frame;
}

void ExpectSame(const vo::FrameResult& a, const vo::FrameResult& b) {
  EXPECT_EQ(a.timestamp_ns, b.timestamp_ns);
  EXPECT_EQ(a.world_from_body.translation, b.world_from_body.translation);
  EXPECT_EQ(a.world_from_body.rotation.coeffs(), b.world_from_body.rotation.coeffs());
  EXPECT_EQ(a.is_keyframe, b.is_keyframe);
  EXPECT_EQ(a.segment, b.segment);
  EXPECT_EQ(a.is_predicted, b.is_predicted);
  EXPECT_EQ(a.is_bridged, b.is_bridged);
  EXPECT_EQ(a.keyframe_from_body.translation, b.keyframe_from_body.translation);
  EXPECT_EQ(a.motion_from_ns, b.motion_from_ns);
  EXPECT_EQ(a.motion_covariance, b.motion_covariance);
  EXPECT_EQ(a.path_covariance, b.path_covariance);
  EXPECT_EQ(a.matched, b.matched);
  EXPECT_EQ(a.landmarks, b.landmarks);
  EXPECT_EQ(a.refused_speed_m_per_s, b.refused_speed_m_per_s);
  EXPECT_EQ(a.stages_ms, b.stages_ms);
  ASSERT_EQ(a.inertial.has_value(), b.inertial.has_value());
  if (a.inertial) {
    EXPECT_EQ(a.inertial->gravity_in_world, b.inertial->gravity_in_world);
    EXPECT_EQ(a.inertial->bias.accelerometer, b.inertial->bias.accelerometer);
    EXPECT_EQ(a.inertial->time_offset_s, b.inertial->time_offset_s);
    EXPECT_EQ(a.inertial->time_offset_sigma_s, b.inertial->time_offset_sigma_s);
  }
}

TEST(FrameLogTest, GivesBackWhatItGotAndLeavesNothing) {
  const TemporaryFolder folder;
  FrameLog log(folder.path());
  for (int i = 0; i < 50; ++i) {
    log.Append(Frame(i));
  }
  EXPECT_EQ(log.Read().size(), 50U);
  log.Append(Frame(50));
  const std::vector<vo::FrameResult> frames = log.Read();
  ASSERT_EQ(frames.size(), 51U);
  for (int i = 0; i < 51; ++i) {
    ExpectSame(frames[i], Frame(i));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(FrameLogTest, AFullDiskIsOneLine) {
  const TemporaryFolder folder;
  FrameLog log(folder.path());
  const FileSizeLimit limit(10'000);
  EXPECT_NE(MessageOf([&] {
              for (int i = 0; i < 100; ++i) {
                log.Append(Frame(i));
              }
            }).find("the record of the frames cannot be written"),
            std::string::npos);
  EXPECT_NE(MessageOf([&] { FrameLog(folder.path() / "absent"); }).find("no file can be made"),
            std::string::npos);
}

}  // namespace
}  // namespace gluevo::apps
