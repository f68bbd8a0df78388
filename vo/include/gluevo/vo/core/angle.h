#pragma once

#include <numbers>

namespace gluevo::vo {

/// One degree, in radians: `5.0 * kDegree` are 5 degrees, `angle / kDegree` is in degrees.
inline constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace gluevo::vo
