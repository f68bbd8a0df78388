#pragma once

#include <Eigen/Core>

namespace gluevo::vo {

/// How the right camera sees, against its calibration, as a run has found so far.
struct RightCameraFinding {
  /// About the right camera's axes, radians: turn.y() moves its image along x, -turn.x() along y,
  /// each by its value on the normalised plane, and turn.z() rotates it.
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_sigma = Eigen::Vector3d::Zero();  ///< One standard deviation each.
  /// It is surely not zero, and made up for.
  bool is_applied = false;
  /// The image is bent as that of a turned camera; else it is moved as a whole, and what bends it
  /// besides is left to lenses.
  bool is_turned = true;
  double focal_px = 0.0;  ///< Of the right camera as calibrated, for all this in pixels.
};

}  // namespace gluevo::vo
