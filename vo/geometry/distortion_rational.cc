#include "distortion_model.h"

namespace gluevo::vo {
namespace {

/// Brown's model with a radial part that is a quotient of polynomials, as OpenCV's calib3d
/// documentation gives it.
Distorted Distort(const DistortionCoefficients& coefficients, const Eigen::Vector2d& p) {
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = coefficients;
  const double r2 = p.x() * p.x() + p.y() * p.y();
  const double above = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
  const double radial = above / below;
  // Twice the derivative by r^2, so that d radial / d x = slope * x.
  const double slope =
      2.0 *
      (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3) - radial * (k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6))) /
      below;
  return WithTangentialPart(p, radial, slope, p1, p2);
}

Eigen::Vector2d Undistort(const DistortionCoefficients& coefficients,
                          const Eigen::Vector2d& target) {
  return InvertDistortion(&Distort, coefficients, target);
}

}  // namespace

const DistortionModel kRationalModel = {"rational", "k1 k2 p1 p2 k3 k4 k5 k6", &Distort,
                                        &Undistort};

}  // namespace gluevo::vo
