#include "gluevo/vo/inertial/gravity.h"

#include <cmath>

namespace gluevo::vo {

GravityTangentMatrix GravityTangent(const Eigen::Vector3d& gravity) {
  const Eigen::Vector3d direction = gravity.normalized();
  // The axis that is furthest from it.
  Eigen::Index axis = 0;
  direction.cwiseAbs().minCoeff(&axis);
  const Eigen::Vector3d first = direction.cross(Eigen::Vector3d::Unit(axis)).normalized();
  GravityTangentMatrix tangent;
  tangent << first, direction.cross(first);
  return gravity.norm() * tangent;
}

Eigen::Vector3d TurnedGravity(const Eigen::Vector3d& gravity, const Eigen::Vector2d& turn) {
  const double angle = turn.norm();
  constexpr double kSmall = 1e-6;
  // sin(a) / a, by its series near zero.
  const double sinc = angle < kSmall ? 1.0 - angle * angle / 6.0 : std::sin(angle) / angle;
  const Eigen::Vector3d turned =
      std::cos(angle) * gravity + sinc * (GravityTangent(gravity) * turn);
  return gravity.norm() * turned.normalized();
}

GravityTangentMatrix GravityEstimate::ByTurn() const {
  const GravityTangentMatrix tangent = GravityTangent(first_in_world);
  const double angle = turn.norm();
  constexpr double kSmall = 1e-6;
  if (angle < kSmall) {
    return tangent - first_in_world * turn.transpose();
  }
  const double sinc = std::sin(angle) / angle;
  const Eigen::Vector2d direction = turn / angle;
  return -sinc * first_in_world * turn.transpose() +
         tangent * (sinc * Eigen::Matrix2d::Identity() +
                    (std::cos(angle) - sinc) * direction * direction.transpose());
}

Eigen::Quaterniond LevelFromWorld(const Eigen::Vector3d& gravity_in_world) {
  const Eigen::Vector3d up = -gravity_in_world.normalized();
  constexpr double kOpposite = -1.0 + 1e-9;
  if (up.z() < kOpposite) {
    return {0.0, 1.0, 0.0, 0.0};
  }
  return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
}

}  // namespace gluevo::vo
