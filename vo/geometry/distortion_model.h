#pragma once

#include <Eigen/Core>
#include <array>

#include "gluevo/vo/geometry/camera.h"

// One file a model. A model is a table of functions; the table of models is in distortion_model.cc.
namespace gluevo::vo {

using DistortionCoefficients = std::array<double, 5>;

/// A map of the normalised plane z = 1 and its derivative at one point.
struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

/// How a lens bends the normalised plane.
struct DistortionModel {
  Distorted (*distort)(const DistortionCoefficients&, const Eigen::Vector2d& normalized);
  /// The inverse on the branch that begins at the centre; NoPoint() where there is none.
  Eigen::Vector2d (*undistort)(const DistortionCoefficients&, const Eigen::Vector2d& distorted);
};

/// Both coordinates NaN.
Eigen::Vector2d NoPoint();

const DistortionModel& ModelOf(Distortion distortion);

extern const DistortionModel kNoDistortion;
extern const DistortionModel kRadialTangentialModel;
extern const DistortionModel kEquidistantModel;

}  // namespace gluevo::vo
