// Loops beside tracking are those that are found in turn.

#include "gluevo/vo/pipeline/loop_thread.h"

#include <gtest/gtest.h>

#include <mutex>
#include <string>

#include "gluevo/nn/error.h"
#include "vo/mapping/recorder_scene.h"

namespace gluevo::vo {
namespace {

constexpr int kPoints = 2000;  // In the room: enough to be sure of a place.
constexpr int kSteps = 70;     // Once around in 63.

// Every third frame is no key frame.
FrameResult ResultOf(int step) {
  FrameResult result = testing::Located(step);
  result.is_keyframe = step % 3 != 2;
  result.keyframe_from_body =
      testing::PlaceAt(step % 3 == 0 ? step - 2 : step - 1).Inverse() * testing::PlaceAt(step);
  return result;
}

bool AddTo(LoopThread& loops, int step) {
  return loops.Add(testing::FrameAt(step), ResultOf(step), testing::SimulatedRig());
}

TEST(LoopThread, FindsWhatIsFoundInTurn) {
  const auto make_recorder = [] {
    return testing::MakeRecorder(std::make_shared<testing::SceneExtractor>(kPoints));
  };
  LoopRecorder in_turn = make_recorder();
  for (int step = 0; step < kSteps; ++step) {
    in_turn.Add(testing::FrameAt(step), ResultOf(step), testing::SimulatedRig());
  }
  ASSERT_GE(in_turn.closer().loops().size(), 3U);
  LoopRecorder recorder = make_recorder();
  LoopThread loops(recorder, nullptr, {.max_frames = 2});
  for (int step = 0; step < kSteps; ++step) {
    ASSERT_TRUE(AddTo(loops, step));
  }
  EXPECT_EQ(loops.Finish().size(), static_cast<std::size_t>(kSteps));
  EXPECT_EQ(loops.loops(), in_turn.closer().loops().size());
  EXPECT_EQ(recorder.closer().attempts().size(), in_turn.closer().attempts().size());
  const Trajectory expected = in_turn.Follow(in_turn.closer().Optimized());
  const Trajectory poses = recorder.Follow(recorder.closer().Optimized());
  ASSERT_EQ(poses.size(), expected.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(poses[i].world_from_body.translation, expected[i].world_from_body.translation);
  }
}

// Waits until it may go on.
class HeldExtractor final : public FeatureExtractor {
 public:
  explicit HeldExtractor(std::mutex& gate) : gate_(gate) {}
  nn::Features Extract(const cv::Mat& image) override {
    const std::lock_guard lock(gate_);
    return testing::SceneExtractor().Extract(image);
  }
  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& /*pixels*/) override {
    return Extract(image);
  }

 private:
  std::mutex& gate_;
};

TEST(LoopThread, ThatDoesNotWaitKeepsNoMoreThanItHasRoomForButKnowsAllPoses) {
  std::mutex gate;
  LoopRecorder recorder = testing::MakeRecorder(std::make_shared<HeldExtractor>(gate));
  LoopThread loops(recorder, nullptr, {.max_frames = 4, .waits = false});
  {
    const std::lock_guard lock(gate);
    for (int step = 0; step < kSteps; ++step) {
      ASSERT_TRUE(AddTo(loops, step));
    }
  }
  loops.Finish();
  // Those that waited, and the one at work.
  EXPECT_GE(recorder.closer().keyframes().size(), 4U);
  EXPECT_LE(recorder.closer().keyframes().size(), 5U);
  EXPECT_EQ(recorder.Follow(recorder.closer().Optimized()).size(),
            static_cast<std::size_t>(kSteps));
}

TEST(LoopThread, PassesOverWhatWaits) {
  std::mutex gate;
  LoopRecorder recorder = testing::MakeRecorder(std::make_shared<HeldExtractor>(gate));
  LoopThread loops(recorder, nullptr);
  {
    const std::lock_guard lock(gate);
    for (int step = 0; step < 20; ++step) {
      ASSERT_TRUE(AddTo(loops, step));
    }
    loops.PassOverWaiting();
  }
  loops.Finish();
  EXPECT_LE(recorder.closer().keyframes().size(), 1U);
  EXPECT_EQ(recorder.Follow(recorder.closer().Optimized()).size(), 20U);
}

TEST(LoopThread, ShowsTheRecorderBetweenFrames) {
  LoopRecorder recorder = testing::MakeRecorder();
  LoopThread loops(recorder, nullptr);
  for (int step = 0; step < kSteps; ++step) {
    AddTo(loops, step);
    loops.Look([&](const LoopRecorder& shown) {
      EXPECT_LE(shown.closer().keyframes().size(), static_cast<std::size_t>(step) + 1);
    });
  }
  loops.Finish();
}

class FailingExtractor final : public FeatureExtractor {
 public:
  nn::Features Extract(const cv::Mat& /*image*/) override { throw Error("no such network"); }
  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& /*pixels*/) override {
    return Extract(image);
  }
};

TEST(LoopThread, TellsWhatItsRecorderThrows) {
  LoopRecorder recorder = testing::MakeRecorder(std::make_shared<FailingExtractor>());
  LoopThread loops(recorder, nullptr, {.max_frames = 1});
  int step = 0;
  while (AddTo(loops, step)) {
    ++step;  // Ends, since there is room for one only.
  }
  try {
    loops.Finish();
    FAIL() << "threw nothing";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()), "no such network");
  }
}

TEST(FeaturesKnownOf, AreTheFrontEndsOfKeyFrames) {
  ExtractorMemo memo(std::make_unique<testing::SceneExtractor>());
  const StereoFrame frame = testing::FrameAt(3);
  memo.Extract(frame.images[0]);
  const KnownFeatures known = FeaturesKnownOf(&memo, frame, testing::Located(3));
  ASSERT_TRUE(known[0].has_value());
  EXPECT_EQ(known[0]->keypoints, testing::SceneExtractor().Extract(frame.images[0]).keypoints);
  EXPECT_FALSE(known[1].has_value());
  EXPECT_FALSE(FeaturesKnownOf(&memo, frame, ResultOf(2))[0].has_value());
  EXPECT_FALSE(FeaturesKnownOf(nullptr, frame, testing::Located(3))[0].has_value());
}

}  // namespace
}  // namespace gluevo::vo
