#pragma once

#include <array>
#include <string>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/geometry/camera.h"

namespace gluevo::vo {

/// Two cameras on one body. Index 0 is the left camera, 1 the right.
struct StereoRig {
  std::array<Camera, 2> cameras;
  std::array<Rigid3, 2> body_from_cam;
  /// What the body frame is, for file headers: "imu (body)" or "left camera".
  std::string body_frame;

  Rigid3 right_from_left() const { return body_from_cam[1].Inverse() * body_from_cam[0]; }
  /// Where the right camera is, in the left one's frame, metres.
  Eigen::Vector3d RightInLeft() const {
    return (body_from_cam[0].Inverse() * body_from_cam[1]).translation;
  }
  /// Distance of the two camera centres, metres.
  double baseline() const { return right_from_left().translation.norm(); }

  /// Throws Error naming `what` for an invalid camera, a pose that is not finite, two cameras in
  /// the same place, a baseline that cannot be in metres (under 1 mm, over 10 m), and for cameras
  /// side by side of which the right one is on the left.
  void Validate(const std::string& what) const;
  /// What is unusual about a valid rig, a sentence each: usually a mistake of the calibration, yet
  /// there are such rigs.
  std::vector<std::string> Oddities() const;
};

}  // namespace gluevo::vo
