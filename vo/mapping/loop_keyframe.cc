#include "gluevo/vo/mapping/loop_keyframe.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "gluevo/vo/geometry/epipolar.h"
#include "gluevo/vo/geometry/triangulation.h"

namespace gluevo::vo {
namespace {

// Of a doubtful motion, radians and metres.
constexpr double kDoubtfulTurn = 0.3;
constexpr double kShortestDoubt = 0.1;

Eigen::Vector2d PixelOf(const nn::Features& features, int i) {
  return i < 0 ? Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN())
               : Eigen::Vector2d(features.keypoints.row(i).transpose().cast<double>());
}

}  // namespace

PoseCovariance DoubtfulMotion(const PoseCovariance& covariance, const Rigid3& motion) {
  const double metres = std::max(kShortestDoubt, motion.translation.norm());
  PoseCovariance doubtful = covariance;
  doubtful.diagonal().head<3>().array() += metres * metres;
  doubtful.diagonal().tail<3>().array() += kDoubtfulTurn * kDoubtfulTurn;
  return doubtful;
}

bool IsDoubtful(const PoseCovariance& motion_covariance) {
  return motion_covariance.diagonal().tail<3>().minCoeff() >= kDoubtfulTurn * kDoubtfulTurn;
}

std::vector<StereoKeypoint> LocateKeypoints(const StereoRig& rig, const nn::Features& left,
                                            const std::vector<Eigen::Vector2d>& right_pixels,
                                            double max_epipolar_error_px) {
  const EpipolarCheck epipolar(rig);
  const Rigid3 right_from_left = rig.right_from_left();
  std::vector<StereoKeypoint> keypoints(static_cast<std::size_t>(left.size()));
  for (int i = 0; i < left.size(); ++i) {
    StereoKeypoint& keypoint = keypoints[i];
    keypoint.left = rig.cameras[0].Undistort(PixelOf(left, i));
    if (!right_pixels[i].allFinite()) {
      continue;
    }
    keypoint.right = rig.cameras[1].Undistort(right_pixels[i]);
    keypoint.has_right = epipolar.Allows(keypoint.left, keypoint.right, max_epipolar_error_px);
    if (!keypoint.has_right) {
      continue;
    }
    const std::array<PosedObservation, 2> views = {PosedObservation{{}, keypoint.left},
                                                   {right_from_left, keypoint.right}};
    if (const std::optional<Eigen::Vector3d> point = Triangulate(views, {})) {
      keypoint.inverse_depth = 1.0 / point->z();
    }
  }
  return keypoints;
}

std::vector<StereoKeypoint> LocateKeypoints(const StereoRig& rig, const nn::Features& left,
                                            const nn::Features& right, const nn::Matches& stereo,
                                            double max_epipolar_error_px) {
  std::vector<Eigen::Vector2d> right_pixels;
  right_pixels.reserve(stereo.matches0.size());
  for (const int match : stereo.matches0) {
    right_pixels.push_back(PixelOf(right, match));
  }
  return LocateKeypoints(rig, left, right_pixels, max_epipolar_error_px);
}

}  // namespace gluevo::vo
