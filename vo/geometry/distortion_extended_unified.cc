#include <cmath>

#include "distortion_model.h"

namespace gluevo::vo {
namespace {

/// Khomutenko, Garcia and Martinet 2016, for points of the plane z = 1.
Distorted Distort(const DistortionCoefficients& coefficients, const Eigen::Vector2d& p) {
  const double alpha = coefficients[0];
  const double beta = coefficients[1];
  const double distance = std::sqrt(1.0 + beta * p.squaredNorm());
  const double scale = 1.0 / (alpha * distance + 1.0 - alpha);
  return ScaledAlongRadius(p, scale, -scale * scale * alpha * beta / distance);
}

Eigen::Vector2d Undistort(const DistortionCoefficients& coefficients,
                          const Eigen::Vector2d& target) {
  const double alpha = coefficients[0];
  const double beta = coefficients[1];
  const double r2 = target.squaredNorm();
  const double root = std::sqrt(1.0 - (2.0 * alpha - 1.0) * beta * r2);  // NaN out of range
  const double mz = (1.0 - beta * alpha * alpha * r2) / (alpha * root + 1.0 - alpha);
  return mz > 0.0 ? CheckedInverse(&Distort, coefficients, target, target / mz) : NoPoint();
}

std::string_view Fault(const DistortionCoefficients& coefficients) {
  if (!(coefficients[0] >= 0.0 && coefficients[0] <= 1.0)) {
    return "alpha is not in 0 to 1";
  }
  return coefficients[1] > 0.0 ? "" : "beta is not positive";
}

}  // namespace

const DistortionModel kExtendedUnifiedModel = {"EUCM", "alpha beta", &Distort, &Undistort, &Fault};

}  // namespace gluevo::vo
