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

const DistortionModel kNoDistortion = {"none", "", &Distort, &Undistort};

}  // namespace gluevo::vo
