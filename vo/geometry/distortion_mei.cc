#include <cmath>

#include "distortion_model.h"

namespace gluevo::vo {
namespace {

/// The radial-tangential part, k1 k2 p1 p2, acts after the sphere.
DistortionCoefficients OfPlane(const DistortionCoefficients& coefficients) {
  return {coefficients[1], coefficients[2], coefficients[3], coefficients[4]};
}

/// Mei and Rives 2007: onto the unit sphere, then from a centre xi behind the sphere's onto a
/// plane.
Distorted Distort(const DistortionCoefficients& coefficients, const Eigen::Vector2d& p) {
  const double xi = coefficients[0];
  const double distance = std::sqrt(1.0 + p.squaredNorm());
  const double scale = 1.0 / (1.0 + xi * distance);
  const Distorted sphere = ScaledAlongRadius(p, scale, -xi * scale * scale / distance);
  const Distorted plane = kRadialTangentialModel.distort(OfPlane(coefficients), sphere.point);
  return {plane.point, plane.jacobian * sphere.jacobian};
}

Eigen::Vector2d Undistort(const DistortionCoefficients& coefficients,
                          const Eigen::Vector2d& target) {
  const double xi = coefficients[0];
  const Eigen::Vector2d m = kRadialTangentialModel.undistort(OfPlane(coefficients), target);
  const double r2 = m.squaredNorm();
  // The sphere's point is (lift m, lift - xi).
  const double lift = (xi + std::sqrt(1.0 + (1.0 - xi * xi) * r2)) / (1.0 + r2);
  const double z = lift - xi;
  return z > 0.0 ? CheckedInverse(&Distort, coefficients, target, lift / z * m) : NoPoint();
}

std::string_view Fault(const DistortionCoefficients& coefficients) {
  return coefficients[0] >= 0.0 ? "" : "xi is negative";
}

}  // namespace

const DistortionModel kMeiModel = {"MEI (omni)", "xi k1 k2 p1 p2", &Distort, &Undistort, &Fault};

}  // namespace gluevo::vo
