#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>

#include "gluevo/vo/geometry/camera.h"

// One file a model. A model is a table of functions; the table of models is in distortion_model.cc.
namespace gluevo::vo {

/// A map of the normalised plane z = 1 and its derivative at one point.
struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

using DistortFunction = Distorted (*)(const DistortionCoefficients&,
                                      const Eigen::Vector2d& normalized);

/// How a lens bends the normalised plane.
struct DistortionModel {
  std::string_view name;
  /// Separated by blanks.
  std::string_view coefficients;
  DistortFunction distort;
  /// The inverse on the branch that begins at the centre; NoPoint() where there is none.
  Eigen::Vector2d (*undistort)(const DistortionCoefficients&, const Eigen::Vector2d& distorted);
  /// What is wrong with finite coefficients, empty for nothing; null where any will do.
  std::string_view (*fault)(const DistortionCoefficients&) = nullptr;
};

/// Both coordinates NaN.
Eigen::Vector2d NoPoint();

const DistortionModel& ModelOf(Distortion distortion);

/// The inverse of a polynomial distortion, by Newton's iteration.
Eigen::Vector2d InvertDistortion(DistortFunction distort,
                                 const DistortionCoefficients& coefficients,
                                 const Eigen::Vector2d& target);

/// A map p -> scale(|p|^2) p of the plane and its derivative. `slope` is twice the derivative of
/// the scale by |p|^2.
Distorted ScaledAlongRadius(const Eigen::Vector2d& p, double scale, double slope);

/// The same, and the tangential part of Brown's model with it, in OpenCV's terms and signs.
Distorted WithTangentialPart(const Eigen::Vector2d& p, double scale, double slope, double p1,
                             double p2);

/// `candidate` where it is a finite point that `distort` takes to `target`, else NoPoint(): closed
/// forms also answer outside of their range.
Eigen::Vector2d CheckedInverse(DistortFunction distort, const DistortionCoefficients& coefficients,
                               const Eigen::Vector2d& target, const Eigen::Vector2d& candidate);

extern const DistortionModel kNoDistortion;
extern const DistortionModel kRadialTangentialModel;
extern const DistortionModel kEquidistantModel;
extern const DistortionModel kRationalModel;
extern const DistortionModel kMeiModel;
extern const DistortionModel kDoubleSphereModel;
extern const DistortionModel kExtendedUnifiedModel;
extern const DistortionModel kFieldOfViewModel;

}  // namespace gluevo::vo
