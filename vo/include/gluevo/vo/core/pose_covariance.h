#pragma once

#include <Eigen/Core>

namespace gluevo::vo {

/// How good a pose a_from_b is: the covariance of its error in the axes of b, the position's first
/// (x, y, z, metres), then the rotation's (rx, ry, rz, radians). The true pose is
/// (p + R dp, R exp(dr)).
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

}  // namespace gluevo::vo
