#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <unordered_map>

namespace gluevo::vo {

/// What an inertial unit says beforehand of a frame's left image, beside that of the last frame
/// that was not passed over.
struct ExpectedView {
  /// Takes directions in the left camera as it was then to directions in the left camera now.
  Eigen::Quaterniond now_from_last = Eigen::Quaterniond::Identity();
  /// Where points with a known depth will be, by their tracks: pixels of the left image. Empty
  /// where only the turn is known.
  std::unordered_map<int64_t, Eigen::Vector2d> pixels;
};

}  // namespace gluevo::vo
