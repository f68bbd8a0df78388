#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

// Gravity's length is known; its direction has two degrees of freedom, on the sphere.
namespace gluevo::vo {

using GravityTangentMatrix = Eigen::Matrix<double, 3, 2>;

/// Derivative of TurnedGravity by its second argument at zero, m/s^2 a radian: two columns of
/// gravity's length, perpendicular to it and to each other. The same for the same gravity.
GravityTangentMatrix GravityTangent(const Eigen::Vector3d& gravity);

/// Gravity (m/s^2, not zero) turned by |turn| radians towards GravityTangent(gravity) * turn; its
/// length stays.
Eigen::Vector3d TurnedGravity(const Eigen::Vector3d& gravity, const Eigen::Vector2d& turn);

/// Gravity as a solver estimates it: turned away from where it was first known, by
/// TurnedGravity(first_in_world, turn). The turn, radians, is what changes.
struct GravityEstimate {
  Eigen::Vector3d first_in_world = {0.0, 0.0, -9.80665};  ///< m/s^2, downwards.
  Eigen::Vector2d turn = Eigen::Vector2d::Zero();

  Eigen::Vector3d InWorld() const { return TurnedGravity(first_in_world, turn); }
  /// The derivative of InWorld() by the turn, where that is now.
  GravityTangentMatrix ByTurn() const;
};

/// The turn about a horizontal axis that takes this gravity to -z: z_up_from_world, whose yaw is
/// that of the world. For gravity straight up the turn is about x.
Eigen::Quaterniond LevelFromWorld(const Eigen::Vector3d& gravity_in_world);

}  // namespace gluevo::vo
