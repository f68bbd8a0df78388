#include "keyframe_views.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>

#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/frontend/optical_flow.h"

namespace gluevo::vo::internal {
namespace {

constexpr double kMaxEpipolarErrorPx = 3.0;
// Of a frame's keypoints: where optical flow finds so many in the right image the network need not
// look at that.
constexpr double kEnoughFollowed = 0.5;

// Where optical flow finds the left image's keypoints in the right one, pixels; NaN where it does
// not.
std::vector<Eigen::Vector2d> FollowAcross(const StereoFrame& frame, const nn::Features& features) {
  constexpr FlowOptions kCoarse = {.window = 21, .levels = 4, .levels_back = 1};
  constexpr FlowOptions kFine = {.window = 11, .levels = 1, .levels_back = 1};
  constexpr double kMaxRefinementPx = 3.0;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<Eigen::Vector2d> found(static_cast<std::size_t>(features.size()), {kNone, kNone});
  const cv::Mat& left = frame.images[0];
  const cv::Mat& right = frame.images[1];
  if (right.empty() || left.size() != right.size() ||
      left.size() != cv::Size(features.width, features.height)) {
    return found;
  }
  std::vector<cv::Point2f> pixels;
  pixels.reserve(found.size());
  for (int i = 0; i < features.size(); ++i) {
    pixels.emplace_back(features.keypoints(i, 0), features.keypoints(i, 1));
  }
  const Pyramid from = MakePyramid(left, kCoarse.window, kCoarse.levels);
  const Pyramid to = MakePyramid(right, kCoarse.window, kCoarse.levels);
  const Flow coarse = FollowBothWays(from, to, pixels, pixels, kCoarse);
  const Flow flow = FollowFinely(from, to, pixels, coarse, kFine, kMaxRefinementPx);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (flow.found[i] != 0) {
      found[i] = ToEigen(flow.pixels[i]);
    }
  }
  return found;
}

}  // namespace

void FindKeypoints(const StereoFrame& frame, KnownFeatures known, const StereoRig& rig,
                   FeatureExtractor& extractor, Matcher& matcher, float threshold,
                   LoopKeyframe& keyframe) {
  const auto find = [&](std::size_t side) {
    return known[side] ? *std::move(known[side]) : extractor.Extract(frame.images[side]);
  };
  keyframe.features = find(0);
  keyframe.keypoints = LocateKeypoints(rig, keyframe.features,
                                       FollowAcross(frame, keyframe.features), kMaxEpipolarErrorPx);
  const auto followed = std::count_if(keyframe.keypoints.begin(), keyframe.keypoints.end(),
                                      [](const StereoKeypoint& point) { return point.has_right; });
  if (frame.images[1].empty() ||
      static_cast<double>(followed) >= kEnoughFollowed * keyframe.features.size()) {
    return;
  }
  const nn::Features right = find(1);
  keyframe.keypoints =
      LocateKeypoints(rig, keyframe.features, right,
                      matcher.Match(keyframe.features, right, threshold), kMaxEpipolarErrorPx);
}

int CountFields(const nn::Features& features, const std::vector<int>& keypoints) {
  constexpr std::size_t kSide = 4;
  std::bitset<kSide * kSide> fields;
  for (const int i : keypoints) {
    const auto place = [&](int axis, int size) {
      const float share = features.keypoints(i, axis) / static_cast<float>(size);
      return static_cast<std::size_t>(std::clamp(share, 0.0F, 0.999F) * kSide);
    };
    fields.set(kSide * place(1, features.height) + place(0, features.width));
  }
  return static_cast<int>(fields.count());
}

AnchoredPoint PointOf(const StereoKeypoint& keypoint, const Rigid3& world_from_left,
                      double noise_px, double baseline) {
  // Two keypoints' errors, along the baseline.
  const double sigma = std::sqrt(2.0) * FromReferencePx(noise_px) / baseline;
  return {world_from_left.translation, world_from_left.rotation * keypoint.left.homogeneous(),
          keypoint.inverse_depth, sigma};
}

}  // namespace gluevo::vo::internal
