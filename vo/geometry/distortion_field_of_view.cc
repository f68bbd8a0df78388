#include <cmath>
#include <numbers>

#include "distortion_model.h"

namespace gluevo::vo {
namespace {

// Below, tan(r w) / (r w) is 1 to the last digit.
constexpr double kAtCentre = 1e-9;

/// Devernay and Faugeras 2001: the distance from the centre is proportional to the angle as a
/// camera of w radians sees it.
Distorted Distort(const DistortionCoefficients& coefficients, const Eigen::Vector2d& p) {
  const double w = coefficients[0];
  const double widen = 2.0 * std::tan(0.5 * w);
  const double r = p.norm();
  if (r * widen < kAtCentre) {
    return ScaledAlongRadius(p, widen / w, 0.0);
  }
  const double across = std::atan(r * widen) / (w * r);
  const double along = widen / (w * (1.0 + r * r * widen * widen));
  return ScaledAlongRadius(p, across, (along - across) / (r * r));
}

Eigen::Vector2d Undistort(const DistortionCoefficients& coefficients,
                          const Eigen::Vector2d& target) {
  const double w = coefficients[0];
  const double widen = 2.0 * std::tan(0.5 * w);
  const double distance = target.norm();
  const double angle = distance * w;
  if (!(angle < 0.5 * std::numbers::pi)) {
    return NoPoint();
  }
  const double scale = angle < kAtCentre ? w / widen : std::tan(angle) / (widen * distance);
  return CheckedInverse(&Distort, coefficients, target, scale * target);
}

std::string_view Fault(const DistortionCoefficients& coefficients) {
  constexpr double kSmallest = 1e-6;  // As good as none, where tan(w / 2) / w has digits left.
  return coefficients[0] >= kSmallest && coefficients[0] < std::numbers::pi
             ? ""
             : "w is not an angle of 0 to pi";
}

}  // namespace

const DistortionModel kFieldOfViewModel = {"field of view", "w", &Distort, &Undistort, &Fault};

}  // namespace gluevo::vo
