#include "view_state.h"

#include <gtest/gtest.h>

#include <cstring>

namespace gluevo::apps {
namespace {

uint32_t Number(const std::string& message) {
  uint32_t number = 0;
  std::memcpy(&number, message.data() + 4, sizeof(number));
  return number;
}

float Float(const std::string& message, std::size_t index) {
  float value = 0.0F;
  std::memcpy(&value, message.data() + 8 + sizeof(float) * index, sizeof(value));
  return value;
}

vo::Rigid3 At(double x) { return {Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}; }

TEST(ViewStateTest, APageGetsWhatItDoesNotHave) {
  ViewState state;
  ViewState::Cursor page;
  EXPECT_EQ(state.Next(page), nullptr);
  state.AddPose(At(1.0), TrackingState::kTracking);
  state.AddPose(At(2.0), TrackingState::kPredicted);
  state.AddLandmarks({{7, {0.5, 0.0, 0.0}}, {8, {1.5, 0.0, 0.0}}});
  state.SetStatus("{}");
  state.SetImage("[1]", {0xff, 0xd8});

  ViewState::Message message = state.Next(page);
  EXPECT_EQ(message->at(0), 1);
  EXPECT_EQ(Number(*message), 0U);
  ASSERT_EQ(message->size(), 8 + 2 * 8 * sizeof(float));
  EXPECT_EQ(Float(*message, 8), 2.0F);
  EXPECT_EQ(Float(*message, 14), 1.0F);
  EXPECT_EQ(Float(*message, 15), 1.0F);
  EXPECT_EQ(*state.Next(page), std::string("\4\0\0\0{}", 6));
  message = state.Next(page);
  EXPECT_EQ(message->at(0), 2);
  EXPECT_EQ(Float(*message, 3), 1.5F);
  EXPECT_EQ(*state.Next(page), std::string("\3\0\0\0\3\0\0\0[1]\xff\xd8", 13));
  EXPECT_EQ(state.Next(page), nullptr);

  state.AddPose(At(3.0), TrackingState::kTracking);
  state.AddLandmarks({{8, {9.0, 0.0, 0.0}}, {9, {2.5, 0.0, 0.0}}});
  message = state.Next(page);
  EXPECT_EQ(Number(*message), 2U);
  EXPECT_EQ(message->size(), 8 + 8 * sizeof(float));
  message = state.Next(page);
  EXPECT_EQ(Number(*message), 2U);
  EXPECT_EQ(message->size(), 8 + 3 * sizeof(float)) << "only the new one";
  EXPECT_EQ(state.Next(page), nullptr);
}

TEST(ViewStateTest, ASlowPageGetsTheNewestImageOnly) {
  ViewState state;
  ViewState::Cursor page;
  for (int i = 0; i < 100; ++i) {
    state.SetImage(std::to_string(i), {});
    state.SetStatus(std::to_string(i));
  }
  EXPECT_EQ(*state.Next(page), std::string("\4\0\0\0", 4) + "99");
  EXPECT_EQ(state.Next(page)->substr(8), "99");
  EXPECT_EQ(state.Next(page), nullptr);
}

TEST(ViewStateTest, HoursStaySmall) {
  ViewState state;
  ViewState::Cursor late;
  ViewState::Cursor early;
  std::size_t longest = 0;
  for (int i = 0; i < 100'000; ++i) {
    state.AddPose(At(i), TrackingState::kTracking);
    state.AddLandmarks({{i, {static_cast<double>(i), 0.0, 0.0}}});
    while (const ViewState::Message message = state.Next(early)) {
      longest = std::max(longest, message->size());
    }
  }
  std::size_t poses = 0;
  std::size_t landmarks = 0;
  float newest = 0.0F;
  while (const ViewState::Message message = state.Next(late)) {
    longest = std::max(longest, message->size());
    if (message->at(0) == 1) {
      EXPECT_EQ(Number(*message), poses);
      poses += (message->size() - 8) / (8 * sizeof(float));
      newest = Float(*message, (message->size() - 8) / sizeof(float) - 8);
    } else {
      landmarks += (message->size() - 8) / (3 * sizeof(float));
    }
  }
  EXPECT_LE(poses, 20'000U);
  EXPECT_GE(poses, 10'000U);
  EXPECT_EQ(newest, 99'999.0F);
  EXPECT_LE(landmarks, 40'000U);
  EXPECT_GE(landmarks, 20'000U);
  EXPECT_LE(longest, 128'008U);
  EXPECT_EQ(early.poses, late.poses);
}

}  // namespace
}  // namespace gluevo::apps
