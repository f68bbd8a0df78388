#include "gluevo/vo/geometry/right_image_offset.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {

Eigen::Matrix3d RightImageOffset::Matrix() const {
  Eigen::Matrix3d moves = Skew(turn);
  moves.row(2) *= bend;
  return Eigen::Matrix3d::Identity() + moves;
}

Eigen::Matrix3d RightImageOffset::ByTurn(const Eigen::Vector3d& point) const {
  Eigen::Matrix3d by_turn = -Skew(point);
  by_turn.row(2) *= bend;
  return by_turn;
}

RightImageUndo::RightImageUndo(const RightImageOffset& correction)
    : inverse_(correction.Matrix().inverse()) {}

Eigen::Vector2d RightImageUndo::operator()(const Eigen::Vector2d& seen) const {
  return (inverse_ * seen.homogeneous()).hnormalized();
}

}  // namespace gluevo::vo
