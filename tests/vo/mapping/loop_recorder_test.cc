// Which frames of a run are kept as places, and what is known of the motions between them.

#include "gluevo/vo/mapping/loop_recorder.h"

#include <gtest/gtest.h>

#include "vo/mapping/recorder_scene.h"

namespace gluevo::vo {
namespace {

using testing::FrameAt;
using testing::kStepNs;
using testing::Located;
using testing::MakeRecorder;
using testing::PlaceAt;
using testing::Predicted;

void Add(LoopRecorder& recorder, int step, const FrameResult& result) {
  recorder.Add(FrameAt(step), result, testing::SimulatedRig());
}

TEST(LoopRecorder, PredictedFramesBeforeALossAreKept) {
  LoopRecorder recorder = MakeRecorder();
  for (const int step : {0, 1, 2}) {
    Add(recorder, step, Located(step));
  }
  for (const int step : {3, 4}) {
    Add(recorder, step, Predicted(step, 2));
  }
  EXPECT_EQ(recorder.closer().keyframes().size(), 3U);  // They may yet be followed.
  Add(recorder, 5, Located(5, /*segment=*/1));
  const std::vector<LoopKeyframe>& kept = recorder.closer().keyframes();
  ASSERT_EQ(kept.size(), 6U);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(kept[i].timestamp_ns, i * kStepNs);
    EXPECT_EQ(kept[i].segment, i < 5 ? 0 : 1);
    if (i > 0 && i < 5) {
      EXPECT_LT(Minus(kept[i].motion, PlaceAt(i - 1).Inverse() * PlaceAt(i)).norm(), 1e-9) << i;
    }
  }
  EXPECT_GE(kept[3].motion_covariance(0, 0), 1e-2);
  EXPECT_EQ(recorder.Follow(recorder.closer().Optimized()).size(), 6U);
}

TEST(LoopRecorder, PredictedFramesThatAreFollowedAreNot) {
  LoopRecorder recorder = MakeRecorder();
  Add(recorder, 0, Located(0));
  Add(recorder, 1, Predicted(1, 0));
  FrameResult found = Located(2);
  found.keyframe_from_body = PlaceAt(0).Inverse() * PlaceAt(2);
  Add(recorder, 2, found);
  Add(recorder, 3, Located(3, /*segment=*/1));
  const std::vector<LoopKeyframe>& kept = recorder.closer().keyframes();
  ASSERT_EQ(kept.size(), 3U);
  EXPECT_EQ(kept[1].timestamp_ns, 2 * kStepNs);
  EXPECT_LT(Minus(kept[1].motion, PlaceAt(0).Inverse() * PlaceAt(2)).norm(), 1e-9);
}

TEST(LoopRecorder, MotionsAreThoseThatTheWindowHasInTheEnd) {
  LoopRecorder recorder = MakeRecorder();
  Add(recorder, 0, Located(0));
  FrameResult wrong = Located(1);
  wrong.world_from_body.translation += Eigen::Vector3d(2.0, 0.0, 0.0);
  Add(recorder, 1, wrong);
  EXPECT_GT((recorder.closer().keyframes()[1].motion.translation -
             (PlaceAt(0).Inverse() * PlaceAt(1)).translation)
                .norm(),
            1.0);
  FrameResult next = Located(2);
  for (int i = 0; i < 3; ++i) {
    next.window.push_back({i * kStepNs, PlaceAt(i)});
  }
  Add(recorder, 2, next);
  const std::vector<LoopKeyframe>& kept = recorder.closer().keyframes();
  ASSERT_EQ(kept.size(), 3U);
  for (int i = 1; i < 3; ++i) {
    EXPECT_LT(Minus(kept[i].motion, PlaceAt(i - 1).Inverse() * PlaceAt(i)).norm(), 1e-9) << i;
  }
  // What was given for it stays.
  EXPECT_EQ(kept[1].world_from_body.translation, wrong.world_from_body.translation);
}

}  // namespace
}  // namespace gluevo::vo
