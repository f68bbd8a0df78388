#include <cmath>

#include "distortion_model.h"

namespace gluevo::vo {
namespace {

/// Usenko, Demmel and Cremers 2018, equations 40 to 45, for points of the plane z = 1.
Distorted Distort(const DistortionCoefficients& coefficients, const Eigen::Vector2d& p) {
  const double xi = coefficients[0];
  const double alpha = coefficients[1];
  const double r2 = p.squaredNorm();
  const double d1 = std::sqrt(1.0 + r2);
  const double shifted = xi * d1 + 1.0;
  const double d2 = std::sqrt(r2 + shifted * shifted);
  const double scale = 1.0 / (alpha * d2 + (1.0 - alpha) * shifted);
  // Twice the derivatives by r^2.
  const double shifted_slope = xi / d1;
  const double d2_slope = (1.0 + shifted * shifted_slope) / d2;
  const double slope = -scale * scale * (alpha * d2_slope + (1.0 - alpha) * shifted_slope);
  return ScaledAlongRadius(p, scale, slope);
}

Eigen::Vector2d Undistort(const DistortionCoefficients& coefficients,
                          const Eigen::Vector2d& target) {
  const double xi = coefficients[0];
  const double alpha = coefficients[1];
  const double r2 = target.squaredNorm();
  const double root = std::sqrt(1.0 - (2.0 * alpha - 1.0) * r2);  // NaN out of range
  const double mz = (1.0 - alpha * alpha * r2) / (alpha * root + 1.0 - alpha);
  const double lift = (mz * xi + std::sqrt(mz * mz + (1.0 - xi * xi) * r2)) / (mz * mz + r2);
  const double z = lift * mz - xi;
  return z > 0.0 ? CheckedInverse(&Distort, coefficients, target, lift / z * target) : NoPoint();
}

std::string_view Fault(const DistortionCoefficients& coefficients) {
  if (!(coefficients[0] > -1.0 && coefficients[0] <= 1.0)) {
    return "xi is not above -1 and at most 1";
  }
  return coefficients[1] >= 0.0 && coefficients[1] <= 1.0 ? "" : "alpha is not in 0 to 1";
}

}  // namespace

const DistortionModel kDoubleSphereModel = {"double sphere", "xi alpha", &Distort, &Undistort,
                                            &Fault};

}  // namespace gluevo::vo
