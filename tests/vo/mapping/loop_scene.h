#pragma once

#include <random>
#include <utility>
#include <vector>

#include "gluevo/nn/features.h"
#include "gluevo/vo/mapping/loop_keyframe.h"
#include "vo/scene.h"

/// Key frames of a simulated room whose points have descriptors of their own.
namespace gluevo::vo::testing {

inline Eigen::VectorXf DescriptorOf(std::size_t point) {
  constexpr int kSize = 32;
  std::mt19937_64 generator(point);
  Eigen::VectorXf descriptor(kSize);
  for (float& value : descriptor) {
    value = static_cast<float>(Gaussian(generator));
  }
  return descriptor.normalized();
}

/// What both cameras see of the points from a place: features and the stereo matches between them.
struct StereoFeatures {
  nn::Features left, right;
  nn::Matches stereo;
};

inline StereoFeatures Look(const StereoRig& rig, const std::vector<Eigen::Vector3d>& points,
                           const Rigid3& world_from_body) {
  std::vector<std::pair<std::size_t, Eigen::Vector2d>> left;
  std::vector<std::pair<std::size_t, Eigen::Vector2d>> right;
  StereoFeatures seen;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Vector2d in_left;
    Eigen::Vector2d in_right;
    if (!Observe(rig, 0, world_from_body, points[i], in_left)) {
      continue;
    }
    left.emplace_back(i, in_left);
    const bool has_right = Observe(rig, 1, world_from_body, points[i], in_right);
    seen.stereo.matches0.push_back(has_right ? static_cast<int>(right.size()) : -1);
    seen.stereo.scores0.push_back(has_right ? 1.0F : 0.0F);
    if (has_right) {
      right.emplace_back(i, in_right);
    }
  }
  const auto make = [](const auto& rays, const Camera& camera, nn::Features& features) {
    features.width = camera.width;
    features.height = camera.height;
    const auto count = static_cast<Eigen::Index>(rays.size());
    features.keypoints.resize(count, 2);
    features.scores.setOnes(count);
    features.descriptors.resize(count, DescriptorOf(0).size());
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto& [point, ray] = rays[i];
      features.keypoints.row(i) << static_cast<float>(camera.fx * ray.x() + camera.cx),
          static_cast<float>(camera.fy * ray.y() + camera.cy);
      features.descriptors.row(i) = DescriptorOf(point);
    }
  };
  make(left, rig.cameras[0], seen.left);
  make(right, rig.cameras[1], seen.right);
  return seen;
}

/// A key frame at a place that odometry takes for another one.
inline LoopKeyframe MakeLoopKeyframe(const StereoRig& rig,
                                     const std::vector<Eigen::Vector3d>& points,
                                     const Rigid3& world_from_body, const Rigid3& by_odometry,
                                     int64_t timestamp_ns) {
  const StereoFeatures seen = Look(rig, points, world_from_body);
  LoopKeyframe keyframe{
      .timestamp_ns = timestamp_ns, .world_from_body = by_odometry, .features = seen.left};
  keyframe.keypoints = LocateKeypoints(rig, seen.left, seen.right, seen.stereo, 1.0);
  return keyframe;
}

}  // namespace gluevo::vo::testing
