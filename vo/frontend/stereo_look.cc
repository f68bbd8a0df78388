#include "gluevo/vo/frontend/stereo_look.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/frontend/optical_flow.h"
#include "gluevo/vo/geometry/epipolar.h"

namespace gluevo::vo {
namespace {

constexpr FlowOptions kFlow = {.window = 21, .levels = 4, .levels_back = 4};
// Wider than any front end's: an old calibration is no wrong one.
constexpr double kMaxEpipolarErrorPx = 4.0;

std::vector<cv::Point2f> Corners(const cv::Mat& image) {
  constexpr int kMost = 200;
  constexpr double kQuality = 0.01;
  constexpr double kMinDistancePx = 10.0;
  // Below this a corner is noise of a black image: OpenCV's measure is relative to the best one.
  constexpr double kLeastContrast = 1.0;
  std::vector<cv::Point2f> corners;
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(image, mean, deviation);
  if (deviation[0] >= kLeastContrast) {
    cv::goodFeaturesToTrack(image, corners, kMost, kQuality, kMinDistancePx);
  }
  return corners;
}

Flow FollowCorners(const cv::Mat& from, const cv::Mat& to,
                   const std::vector<cv::Point2f>& corners) {
  if (corners.empty()) {
    return {};
  }
  return FollowBothWays(MakePyramid(from, kFlow.window, kFlow.levels),
                        MakePyramid(to, kFlow.window, kFlow.levels), corners, corners, kFlow);
}

int CountFound(const Flow& flow) {
  return static_cast<int>(std::count_if(flow.found.begin(), flow.found.end(),
                                        [](unsigned char found) { return found != 0; }));
}

StereoRig Inverted(const StereoRig& rig) {
  StereoRig inverted = rig;
  inverted.body_from_cam = {Rigid3{}, rig.right_from_left()};
  return inverted;
}

}  // namespace

StereoLook LookAt(const StereoFrame& frame, const StereoRig& rig, const cv::Mat& left_before) {
  CheckImages(frame, rig);
  StereoLook look;
  const cv::Mat& left = frame.images[0];
  const cv::Mat& right = frame.images[1];
  for (const std::size_t i : {0, 1}) {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(frame.images[i], mean, deviation);
    look.brightness[i] = mean[0];
    look.contrast[i] = deviation[0];
  }
  look.is_same = left.size() == right.size() && cv::norm(left, right, cv::NORM_INF) == 0.0;
  const std::vector<cv::Point2f> corners = Corners(left);
  look.corners = {static_cast<int>(corners.size()), static_cast<int>(Corners(right).size())};

  const Flow across = FollowCorners(left, right, corners);
  look.found = CountFound(across);
  const EpipolarCheck check(rig);
  const EpipolarCheck inverted(Inverted(rig));
  const std::array<Camera, 2>& cameras = rig.cameras;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (across.found[i] == 0) {
      continue;
    }
    const Eigen::Vector2d in_left = ToEigen(corners[i]);
    const Eigen::Vector2d in_right = ToEigen(across.pixels[i]);
    const auto allows = [&](const EpipolarCheck& by, const Eigen::Vector2d& seen_by_left,
                            const Eigen::Vector2d& seen_by_right) {
      return by.Allows(cameras[0].Undistort(seen_by_left), cameras[1].Undistort(seen_by_right),
                       kMaxEpipolarErrorPx)
                 ? 1
                 : 0;
    };
    look.fit += allows(check, in_left, in_right);
    look.fit_exchanged += allows(check, in_right, in_left);
    look.fit_inverted += allows(inverted, in_left, in_right);
  }
  if (left_before.size() == left.size()) {
    const std::vector<cv::Point2f> before = Corners(left_before);
    look.before = static_cast<int>(before.size());
    look.followed = CountFound(FollowCorners(left_before, left, before));
  }
  return look;
}

}  // namespace gluevo::vo
