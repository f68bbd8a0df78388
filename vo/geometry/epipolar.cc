#include "gluevo/vo/geometry/epipolar.h"

#include <cmath>

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {

EpipolarCheck::EpipolarCheck(const StereoRig& rig)
    : right_from_left_(rig.right_from_left()),
      focal_px_(0.5 * rig.cameras[1].CentralFocal().sum()) {
  essential_ = Skew(right_from_left_.translation) * right_from_left_.rotation.toRotationMatrix();
}

double EpipolarCheck::Distance(const Eigen::Vector2d& left, const Eigen::Vector2d& right) const {
  const Eigen::Vector3d line = essential_ * left.homogeneous();
  return focal_px_ * std::abs(line.dot(right.homogeneous())) / line.head<2>().norm();
}

bool EpipolarCheck::InFront(const Eigen::Vector2d& left, const Eigen::Vector2d& right,
                            double tolerance_px) const {
  // Where the left ray ends in the right view: at infinity, and on its way there from a point that
  // is near the camera. The right point must lie on that side of the end.
  const Eigen::Vector3d direction = right_from_left_.rotation * left.homogeneous();
  if (direction.z() <= 0.0) {
    return false;
  }
  const Eigen::Vector2d infinity = direction.hnormalized();
  const Eigen::Vector3d& t = right_from_left_.translation;
  // d/d(inverse depth) of the projection at inverse depth 0.
  const Eigen::Vector2d towards_near = (t.head<2>() - infinity * t.z()) / direction.z();
  return (right - infinity).dot(towards_near.normalized()) * focal_px_ >= -tolerance_px;
}

}  // namespace gluevo::vo
