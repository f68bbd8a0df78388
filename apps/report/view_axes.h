#pragma once

#include <Eigen/Geometry>
#include <string>

namespace gluevo::apps {

/// A coordinate axis of the world, or its opposite.
struct SignedAxis {
  int index = 0;  ///< 0 to 2: x, y, z.
  int sign = 1;

  double Of(const Eigen::Vector3d& point) const { return sign * point[index]; }
  std::string Name() const { return std::string(1, "xyz"[index]); }
};

/// Seen from above, `right` points right and `forward` up the page; from the side, `right` points
/// right and `up` up. Right-handed: right x forward = up, so nothing is mirrored.
struct ViewAxes {
  SignedAxis right, forward, up;
};

/// The view whose up is the coordinate axis nearest to `up`, turned so that the longer side of
/// `box` lies across the page.
ViewAxes ChooseViewAxes(const Eigen::Vector3d& up, const Eigen::AlignedBox3d& box);

}  // namespace gluevo::apps
