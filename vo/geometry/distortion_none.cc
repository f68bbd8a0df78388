#include <limits>

#include "distortion_model.h"

namespace gluevo::vo {
namespace {

Distorted Distort(const DistortionCoefficients& /*none*/, const Eigen::Vector2d& p) {
  return {p, Eigen::Matrix2d::Identity()};
}

Eigen::Vector2d Undistort(const DistortionCoefficients& /*none*/, const Eigen::Vector2d& target) {
  return target;
}

}  // namespace

Eigen::Vector2d NoPoint() {
  return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
}

const DistortionModel kNoDistortion = {&Distort, &Undistort};

}  // namespace gluevo::vo
