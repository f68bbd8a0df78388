#include "distortion_model.h"

namespace gluevo::vo {
namespace {

/// Brown 1971, with the terms and signs of OpenCV's calib3d documentation.
Distorted Distort(const DistortionCoefficients& coefficients, const Eigen::Vector2d& p) {
  const double k1 = coefficients[0];
  const double k2 = coefficients[1];
  const double p1 = coefficients[2];
  const double p2 = coefficients[3];
  const double k3 = coefficients[4];
  const double r2 = p.x() * p.x() + p.y() * p.y();
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  // Twice the derivative by r^2, so that d radial / d x = slope * x.
  const double slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
  return WithTangentialPart(p, radial, slope, p1, p2);
}

Eigen::Vector2d Undistort(const DistortionCoefficients& coefficients,
                          const Eigen::Vector2d& target) {
  return InvertDistortion(&Distort, coefficients, target);
}

}  // namespace

const DistortionModel kRadialTangentialModel = {"radial-tangential", "k1 k2 p1 p2 k3", &Distort,
                                                &Undistort};

}  // namespace gluevo::vo
