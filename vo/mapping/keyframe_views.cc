#include "keyframe_views.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <utility>

#include "gluevo/vo/core/reference_focal.h"

namespace gluevo::vo::internal {

void FindKeypoints(const StereoFrame& frame, KnownFeatures known, const StereoRig& rig,
                   FeatureExtractor& extractor, Matcher& matcher, float threshold,
                   LoopKeyframe& keyframe) {
  constexpr double kMaxEpipolarErrorPx = 3.0;
  const auto find = [&](std::size_t side) {
    return known[side] ? *std::move(known[side]) : extractor.Extract(frame.images[side]);
  };
  keyframe.features = find(0);
  nn::Features right;
  nn::Matches stereo;
  if (frame.images[1].empty()) {
    stereo.matches0.assign(static_cast<std::size_t>(keyframe.features.size()), -1);
  } else {
    right = find(1);
    stereo = matcher.Match(keyframe.features, right, threshold);
  }
  keyframe.keypoints = LocateKeypoints(rig, keyframe.features, right, stereo, kMaxEpipolarErrorPx);
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
