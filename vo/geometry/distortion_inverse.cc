// The inverse of the distortions that have no closed form.

#include <Eigen/LU>
#include <algorithm>
#include <optional>

#include "distortion_model.h"

namespace gluevo::vo {
namespace {

/// The inverse of the distortion at `target` by Newton's iteration from `start`; nothing where it
/// leaves the region in which the distortion keeps the orientation of the plane.
std::optional<Eigen::Vector2d> Newton(DistortFunction distort,
                                      const DistortionCoefficients& coefficients,
                                      const Eigen::Vector2d& target, const Eigen::Vector2d& start) {
  constexpr int kMostIterations = 30;
  // 1e-9 of a pixel is 1e-12 of the plane or more; rounding stops the iteration well below.
  constexpr double kGoodResidual = 1e-14;
  constexpr double kAcceptedResidual = 1e-13;
  Eigen::Vector2d p = start;
  for (int i = 0; i < kMostIterations; ++i) {
    const Distorted distorted = distort(coefficients, p);
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
  const Distorted last = distort(coefficients, p);
  const double scale = 1.0 + p.norm();
  return (last.point - target).norm() <= kAcceptedResidual * scale &&
                 last.jacobian.determinant() > 0.0
             ? std::optional(p)
             : std::nullopt;
}

/// Whether the distortion is one to one on the way from the centre to p.
bool IsOnCentralBranch(DistortFunction distort, const DistortionCoefficients& coefficients,
                       const Eigen::Vector2d& p) {
  constexpr int kSamples = 16;
  for (int i = 1; i <= kSamples; ++i) {
    const double share = static_cast<double>(i) / kSamples;
    if (!(distort(coefficients, share * p).jacobian.determinant() > 0.0)) {
      return false;
    }
  }
  return true;
}

}  // namespace

Eigen::Vector2d InvertDistortion(DistortFunction distort,
                                 const DistortionCoefficients& coefficients,
                                 const Eigen::Vector2d& target) {
  const std::optional<Eigen::Vector2d> direct = Newton(distort, coefficients, target, target);
  if (direct && IsOnCentralBranch(distort, coefficients, *direct)) {
    return *direct;
  }
  // Near where the polynomial turns, Newton's iteration may jump to another branch; it cannot when
  // it follows the solution from the centre in small steps.
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  double reached = 0.0;
  double step = 1.0 / 16.0;
  constexpr double kLastStep = 1e-6;
  // Lenses need some tens; coefficients that are none could ask for a million.
  constexpr int kMostSteps = 4096;
  for (int steps = 0; reached < 1.0; ++steps) {
    if (steps > kMostSteps) {
      return NoPoint();
    }
    const double next = std::min(1.0, reached + step);
    const std::optional<Eigen::Vector2d> solution = Newton(distort, coefficients, next * target, p);
    if (solution && IsOnCentralBranch(distort, coefficients, *solution)) {
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

}  // namespace gluevo::vo
