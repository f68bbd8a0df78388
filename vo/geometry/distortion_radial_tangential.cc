#include <Eigen/LU>
#include <algorithm>
#include <optional>

#include "distortion_model.h"

namespace gluevo::vo {
namespace {

/// Brown 1971, with the terms and signs of OpenCV's calib3d documentation.
Distorted Distort(const DistortionCoefficients& coefficients, const Eigen::Vector2d& p) {
  const auto& [k1, k2, p1, p2, k3] = coefficients;
  const double x = p.x();
  const double y = p.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  // Twice the derivative by r^2, so that d radial / d x = slope * x.
  const double slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
  Distorted result;
  result.point << x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
      y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
  const double mixed = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
  result.jacobian << radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x, mixed, mixed,
      radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  return result;
}

/// The inverse of the distortion at `target` by Newton's iteration from `start`; nothing where it
/// leaves the region in which the distortion keeps the orientation of the plane.
std::optional<Eigen::Vector2d> Newton(const DistortionCoefficients& coefficients,
                                      const Eigen::Vector2d& target, const Eigen::Vector2d& start) {
  constexpr int kMostIterations = 30;
  // 1e-9 of a pixel is 1e-12 of the plane or more; rounding stops the iteration well below.
  constexpr double kGoodResidual = 1e-14;
  constexpr double kAcceptedResidual = 1e-13;
  Eigen::Vector2d p = start;
  for (int i = 0; i < kMostIterations; ++i) {
    const Distorted distorted = Distort(coefficients, p);
    if (!(distorted.jacobian.determinant() > 0.0)) {
      return std::nullopt;
    }
    const Eigen::Vector2d residual = distorted.point - target;
    const Eigen::Vector2d step = distorted.jacobian.inverse() * residual;
    p -= step;
    if (residual.norm() <= kGoodResidual) {
      return p;
    }
  }
  const Distorted last = Distort(coefficients, p);
  const double scale = 1.0 + p.norm();
  return (last.point - target).norm() <= kAcceptedResidual * scale &&
                 last.jacobian.determinant() > 0.0
             ? std::optional(p)
             : std::nullopt;
}

/// Whether the distortion is one to one on the way from the centre to p.
bool IsOnCentralBranch(const DistortionCoefficients& coefficients, const Eigen::Vector2d& p) {
  constexpr int kSamples = 16;
  for (int i = 1; i <= kSamples; ++i) {
    const double share = static_cast<double>(i) / kSamples;
    if (!(Distort(coefficients, share * p).jacobian.determinant() > 0.0)) {
      return false;
    }
  }
  return true;
}

Eigen::Vector2d Undistort(const DistortionCoefficients& coefficients,
                          const Eigen::Vector2d& target) {
  const std::optional<Eigen::Vector2d> direct = Newton(coefficients, target, target);
  if (direct && IsOnCentralBranch(coefficients, *direct)) {
    return *direct;
  }
  // Near where the polynomial turns, Newton's iteration may jump to another branch; it cannot when
  // it follows the solution from the centre in small steps.
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  double reached = 0.0;
  double step = 1.0 / 16.0;
  constexpr double kLastStep = 1e-6;
  while (reached < 1.0) {
    const double next = std::min(1.0, reached + step);
    const std::optional<Eigen::Vector2d> solution = Newton(coefficients, next * target, p);
    if (solution && IsOnCentralBranch(coefficients, *solution)) {
      p = *solution;
      reached = next;
    } else {
      step /= 2.0;
      if (step < kLastStep) {
        return NoPoint();
      }
    }
  }
  return p;
}

}  // namespace

const DistortionModel kRadialTangentialModel = {&Distort, &Undistort};

}  // namespace gluevo::vo
