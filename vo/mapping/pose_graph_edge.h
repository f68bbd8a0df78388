#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo::internal {

using EdgeError = Eigen::Matrix<double, 6, 1>;
using EdgeJacobian = Eigen::Matrix<double, 6, 6>;

/// ErrorOfPose of a measured `a_from_b` against that of two poses, and its derivatives by their
/// tangents (as Plus has them: position in the world, then turn in the body).
EdgeError ErrorOfEdge(const Rigid3& a_from_b, const Rigid3& world_from_a,
                      const Rigid3& world_from_b, EdgeJacobian* by_a, EdgeJacobian* by_b);

/// d (q * exp(v)) / d v at v = 0, rows as Eigen stores a quaternion (x, y, z, w) ...
Eigen::Matrix<double, 4, 3> QuaternionByTurn(const Eigen::Quaterniond& q);
/// ... and d v / d q back from there, for which the product with the first is the identity.
Eigen::Matrix<double, 3, 4> TurnByQuaternion(const Eigen::Quaterniond& q);

}  // namespace gluevo::vo::internal
