#pragma once

#include <Eigen/Core>

#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::vo {

/// The epipolar geometry of a calibrated rig (Hartley and Zisserman 2004, section 9.6).
class EpipolarCheck {
 public:
  explicit EpipolarCheck(const StereoRig& rig);

  /// Distance of the right point from the left point's epipolar line, in pixels of the right camera
  /// (its mean focal length). Both points on the normalised planes.
  double Distance(const Eigen::Vector2d& left, const Eigen::Vector2d& right) const;

  /// Whether the two rays meet in front of both cameras, or are parallel within `tolerance_px`
  /// pixels of the right camera.
  bool InFront(const Eigen::Vector2d& left, const Eigen::Vector2d& right,
               double tolerance_px) const;

 private:
  Rigid3 right_from_left_;
  Eigen::Matrix3d essential_;  // right^T essential left = 0
  double focal_px_;
};

}  // namespace gluevo::vo
