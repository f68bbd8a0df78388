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

/// The turn about a horizontal axis that takes this gravity to -z: z_up_from_world, whose yaw is
/// that of the world. For gravity straight up the turn is about x.
Eigen::Quaterniond LevelFromWorld(const Eigen::Vector3d& gravity_in_world);

}  // namespace gluevo::vo
