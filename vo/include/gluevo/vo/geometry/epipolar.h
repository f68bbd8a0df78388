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

  /// The rule for all stereo matches: at most `max_error_px` from the line, and in front of both
  /// cameras within as much. False, too, where a pixel is beyond its camera's model and has no ray
  /// (NaN).
  bool Allows(const Eigen::Vector2d& left, const Eigen::Vector2d& right,
              double max_error_px) const {
    return Distance(left, right) <= max_error_px && InFront(left, right, max_error_px);
  }

 private:
  Rigid3 right_from_left_;
  Eigen::Matrix3d essential_;  // right^T essential left = 0
  double focal_px_;
};

}  // namespace gluevo::vo
