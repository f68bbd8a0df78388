#pragma once

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/mapping/loop_recorder.h"
#include "gluevo/vo/mapping/place_training.h"
#include "vo/mapping/loop_scene.h"

// A camera goes around in a room, for what keeps its key frames as places.
namespace gluevo::vo::testing {

inline constexpr int64_t kStepNs = 600'000'000;

inline Rigid3 PlaceAt(int step) {
  const double angle = 0.1 * step;
  return {ExpSo3({0.0, 0.0, angle}), {1.5 * std::cos(angle), 1.5 * std::sin(angle), 0.1}};
}

// Images are of one pixel, which says what they show: twice the step, and one more on the right.
class SceneExtractor final : public FeatureExtractor {
 public:
  /// So many points are on the room's walls.
  explicit SceneExtractor(int points = 600) : points_(RoomPoints(points, 4.0, 3)) {}

  nn::Features Extract(const cv::Mat& image) override {
    const int code = image.at<unsigned char>(0, 0);
    const StereoFeatures seen = Look(SimulatedRig(), points_, PlaceAt(code / 2));
    return code % 2 == 0 ? seen.left : seen.right;
  }
  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& /*pixels*/) override {
    return Extract(image);
  }

 private:
  std::vector<Eigen::Vector3d> points_;
};

inline StereoFrame FrameAt(int step) {
  return {step * kStepNs,
          {cv::Mat(1, 1, CV_8UC1, cv::Scalar(2 * step)),
           cv::Mat(1, 1, CV_8UC1, cv::Scalar(2 * step + 1))}};
}

// As odometry that is right has them, each a key frame.
inline FrameResult Located(int step, int segment = 0) {
  FrameResult result;
  result.timestamp_ns = step * kStepNs;
  result.world_from_body = PlaceAt(step);
  result.is_keyframe = true;
  result.segment = segment;
  result.keyframe_from_body = PlaceAt(step - 1).Inverse() * PlaceAt(step);
  result.motion_covariance.diagonal().setConstant(1e-4);
  return result;
}

inline FrameResult Predicted(int step, int last_located) {
  FrameResult result = Located(step);
  result.is_keyframe = false;
  result.is_predicted = true;
  result.keyframe_from_body = PlaceAt(last_located).Inverse() * PlaceAt(step);
  result.motion_covariance.diagonal().setConstant(1e-2);
  return result;
}

inline LoopRecorder MakeRecorder(
    std::shared_ptr<FeatureExtractor> used = std::make_shared<SceneExtractor>()) {
  SceneExtractor extractor;
  return {SimulatedRig(),
          TrainPlaceCodebook(
              {extractor.Extract(FrameAt(0).images[0]), extractor.Extract(FrameAt(20).images[0])},
              "", {.centres = 4}),
          std::move(used),
          MakeNearestNeighborMatcher(),
          {}};
}

}  // namespace gluevo::vo::testing
