#pragma once

#include <Eigen/Core>

namespace gluevo::vo {

/// How the right camera sees, against what the calibration says: its image turned and shifted a
/// little. To first order in `turn`, which is all there is to milliradians.
///
/// A camera that is turned about its y axis shifts its image by turn * (1 + x^2), a principal point
/// that is off by turn alone. What lenses leave after calibration grows with x^2, too, and is the
/// larger part of that on real rigs, so that the two are kept apart: asked freely, KITTI's data
/// want 2 px * x^2, with a shift of 0.3 px (docs/METHODS.md).
struct RightImageOffset {
  /// About the axes of the right camera, radians. Without `bend` a shift of its image: by turn.y()
  /// along x, by -turn.x() along y, on the normalised plane; turn.z() rotates it.
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  /// How much of the turn's second order there is: 0 the image is shifted, 1 the camera is turned.
  double bend = 1.0;

  /// From a point of the right camera's frame as calibrated to where it is seen.
  Eigen::Matrix3d Matrix() const;
  /// By `turn`, of Matrix() * point.
  Eigen::Matrix3d ByTurn(const Eigen::Vector3d& point) const;
};

/// From where the right camera sees a point to where one as calibrated would, on the normalised
/// plane.
class RightImageUndo {
 public:
  explicit RightImageUndo(const RightImageOffset& correction);
  Eigen::Vector2d operator()(const Eigen::Vector2d& seen) const;

 private:
  Eigen::Matrix3d inverse_;
};

}  // namespace gluevo::vo
