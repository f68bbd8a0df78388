// Which frames of a run are kept as places, and what is known of the motions between them.

#include "gluevo/vo/mapping/loop_recorder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/mapping/place_training.h"
#include "vo/mapping/loop_scene.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kStepNs = 600'000'000;

Rigid3 PlaceAt(int step) {
  const double angle = 0.1 * step;
  return {ExpSo3({0.0, 0.0, angle}), {1.5 * std::cos(angle), 1.5 * std::sin(angle), 0.1}};
}

// Images are of one pixel, which says what they show: twice the step, and one more on the right.
class SceneExtractor final : public FeatureExtractor {
 public:
  nn::Features Extract(const cv::Mat& image) override {
    const int code = image.at<unsigned char>(0, 0);
    const testing::StereoFeatures seen =
        testing::Look(testing::SimulatedRig(), testing::RoomPoints(600, 4.0, 3), PlaceAt(code / 2));
    return code % 2 == 0 ? seen.left : seen.right;
  }
  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& /*pixels*/) override {
    return Extract(image);
  }
};

StereoFrame FrameAt(int step) {
  return {step * kStepNs,
          {cv::Mat(1, 1, CV_8UC1, cv::Scalar(2 * step)),
           cv::Mat(1, 1, CV_8UC1, cv::Scalar(2 * step + 1))}};
}

// As odometry that is right has them, each a key frame.
FrameResult Located(int step, int segment = 0) {
  FrameResult result;
  result.timestamp_ns = step * kStepNs;
  result.world_from_body = PlaceAt(step);
  result.is_keyframe = true;
  result.segment = segment;
  result.keyframe_from_body = PlaceAt(step - 1).Inverse() * PlaceAt(step);
  result.motion_covariance.diagonal().setConstant(1e-4);
  return result;
}

FrameResult Predicted(int step, int last_located) {
  FrameResult result = Located(step);
  result.is_keyframe = false;
  result.is_predicted = true;
  result.keyframe_from_body = PlaceAt(last_located).Inverse() * PlaceAt(step);
  result.motion_covariance.diagonal().setConstant(1e-2);
  return result;
}

LoopRecorder MakeRecorder() {
  SceneExtractor extractor;
  return {testing::SimulatedRig(),
          TrainPlaceCodebook(
              {extractor.Extract(FrameAt(0).images[0]), extractor.Extract(FrameAt(20).images[0])},
              "", {.centres = 4}),
          std::make_shared<SceneExtractor>(),
          MakeNearestNeighborMatcher(),
          {}};
}

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
