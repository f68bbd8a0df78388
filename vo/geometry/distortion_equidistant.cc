#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "distortion_model.h"

namespace gluevo::vo {
namespace {

/// Distance from the image centre, in focal lengths, of a ray at angle theta to the optical axis,
/// and its derivative (Kannala and Brandt 2006, eq. 6, with the first coefficient 1).
struct Angle {
  double distorted;
  double derivative;
};

Angle DistortAngle(const DistortionCoefficients& k, double theta) {
  const double t2 = theta * theta;
  return {theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))),
          1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])))};
}

Distorted Distort(const DistortionCoefficients& coefficients, const Eigen::Vector2d& p) {
  const double r = p.norm();
  // Below, atan(r) / r is 1 to the last digit.
  constexpr double kAtCentre = 1e-9;
  if (r < kAtCentre) {
    return {p, Eigen::Matrix2d::Identity()};
  }
  const Angle angle = DistortAngle(coefficients, std::atan(r));
  const Eigen::Vector2d direction = p / r;
  const double across = angle.distorted / r;
  const double along = angle.derivative / (1.0 + r * r);
  return {across * p, across * Eigen::Matrix2d::Identity() +
                          (along - across) * direction * direction.transpose()};
}

/// The largest angle up to which DistortAngle increases, at most 90 degrees.
double EndOfRange(const DistortionCoefficients& coefficients) {
  constexpr double kRightAngle = std::numbers::pi / 2.0;
  constexpr int kSamples = 64;
  double good = 0.0;
  for (int i = 1; i <= kSamples; ++i) {
    double bad = kRightAngle * i / kSamples;
    if (DistortAngle(coefficients, bad).derivative > 0.0) {
      good = bad;
      continue;
    }
    while (true) {
      const double middle = 0.5 * (good + bad);
      if (!(middle > good && middle < bad)) {
        return good;
      }
      (DistortAngle(coefficients, middle).derivative > 0.0 ? good : bad) = middle;
    }
  }
  return kRightAngle;
}

Eigen::Vector2d Undistort(const DistortionCoefficients& coefficients,
                          const Eigen::Vector2d& target) {
  const double distance = target.norm();
  if (distance == 0.0) {
    return target;
  }
  double low = 0.0;
  double high = EndOfRange(coefficients);
  if (!(distance < DistortAngle(coefficients, high).distorted)) {
    return NoPoint();
  }
  // The angle is the only unknown. Bisection takes over where Newton's step leaves the bracket.
  double theta = std::min(distance, 0.5 * high);
  constexpr int kMostIterations = 100;
  for (int i = 0; i < kMostIterations; ++i) {
    const Angle angle = DistortAngle(coefficients, theta);
    const double residual = angle.distorted - distance;
    (residual > 0.0 ? high : low) = theta;
    double next = theta - residual / angle.derivative;
    if (!(next >= low && next <= high)) {
      next = 0.5 * (low + high);
    }
    const bool settled = std::abs(next - theta) <= std::numeric_limits<double>::epsilon() * theta;
    theta = next;
    if (settled) {
      break;
    }
  }
  return target * (std::tan(theta) / distance);
}

}  // namespace

const DistortionModel kEquidistantModel = {"equidistant", "k1 k2 k3 k4", &Distort, &Undistort};

}  // namespace gluevo::vo
