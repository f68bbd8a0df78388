#include "gluevo/vo/geometry/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

/// A map of the normalised plane and its derivative at one point.
struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

using Coefficients = std::array<double, 5>;

/// Brown 1971, with the terms and signs of OpenCV's calib3d documentation.
Distorted DistortRadialTangential(const Coefficients& coefficients, const Eigen::Vector2d& p) {
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

/// Distance from the image centre, in focal lengths, of a ray at angle theta to the optical axis,
/// and its derivative (Kannala and Brandt 2006, eq. 6, with the first coefficient 1).
struct Angle {
  double distorted;
  double derivative;
};

Angle DistortAngle(const Coefficients& k, double theta) {
  const double t2 = theta * theta;
  return {theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))),
          1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])))};
}

Distorted DistortEquidistant(const Coefficients& coefficients, const Eigen::Vector2d& p) {
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

Distorted DistortNormalized(const Camera& camera, const Eigen::Vector2d& p) {
  switch (camera.distortion) {
    case Distortion::kRadialTangential:
      return DistortRadialTangential(camera.coefficients, p);
    case Distortion::kEquidistant:
      return DistortEquidistant(camera.coefficients, p);
    case Distortion::kNone:
      break;
  }
  return {p, Eigen::Matrix2d::Identity()};
}

Eigen::Vector2d NoPoint() {
  return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
}

/// The inverse of the distortion at `target` by Newton's iteration from `start`; nothing where it
/// leaves the region in which the distortion keeps the orientation of the plane.
std::optional<Eigen::Vector2d> Newton(const Coefficients& coefficients,
                                      const Eigen::Vector2d& target, const Eigen::Vector2d& start) {
  constexpr int kMostIterations = 30;
  // 1e-9 of a pixel is 1e-12 of the plane or more; rounding stops the iteration well below.
  constexpr double kGoodResidual = 1e-14;
  constexpr double kAcceptedResidual = 1e-13;
  Eigen::Vector2d p = start;
  for (int i = 0; i < kMostIterations; ++i) {
    const Distorted distorted = DistortRadialTangential(coefficients, p);
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
  const Distorted last = DistortRadialTangential(coefficients, p);
  const double scale = 1.0 + p.norm();
  return (last.point - target).norm() <= kAcceptedResidual * scale &&
                 last.jacobian.determinant() > 0.0
             ? std::optional(p)
             : std::nullopt;
}

/// Whether the distortion is one to one on the way from the centre to p.
bool IsOnCentralBranch(const Coefficients& coefficients, const Eigen::Vector2d& p) {
  constexpr int kSamples = 16;
  for (int i = 1; i <= kSamples; ++i) {
    const double share = static_cast<double>(i) / kSamples;
    if (!(DistortRadialTangential(coefficients, share * p).jacobian.determinant() > 0.0)) {
      return false;
    }
  }
  return true;
}

Eigen::Vector2d UndistortRadialTangential(const Coefficients& coefficients,
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

/// The largest angle up to which DistortAngle increases, at most 90 degrees.
double EndOfRange(const Coefficients& coefficients) {
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

Eigen::Vector2d UndistortEquidistant(const Coefficients& coefficients,
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

void Camera::Validate(const std::string& what) const {
  if (width <= 0 || height <= 0) {
    throw Error(what + ": the image size " + std::to_string(width) + "x" + std::to_string(height) +
                " is not positive");
  }
  if (!std::isfinite(fx) || !std::isfinite(fy) || fx <= 0.0 || fy <= 0.0) {
    throw Error(what + ": the focal lengths " + std::to_string(fx) + " and " + std::to_string(fy) +
                " are not positive");
  }
  if (!std::isfinite(cx) || !std::isfinite(cy)) {
    throw Error(what + ": the principal point is not finite");
  }
  for (const double coefficient : coefficients) {
    if (!std::isfinite(coefficient)) {
      throw Error(what + ": the distortion coefficients are not finite");
    }
  }
}

Eigen::Vector2d Camera::Project(const Eigen::Vector3d& point_in_cam) const {
  return Distort(point_in_cam.head<2>() / point_in_cam.z());
}

Eigen::Vector2d Camera::Distort(const Eigen::Vector2d& normalized) const {
  const Eigen::Vector2d point = DistortNormalized(*this, normalized).point;
  return {fx * point.x() + cx, fy * point.y() + cy};
}

Eigen::Matrix2d Camera::DistortJacobian(const Eigen::Vector2d& normalized) const {
  return Eigen::Vector2d(fx, fy).asDiagonal() * DistortNormalized(*this, normalized).jacobian;
}

Eigen::Vector2d Camera::Undistort(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d target((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (!target.allFinite()) {
    return NoPoint();
  }
  switch (distortion) {
    case Distortion::kRadialTangential:
      return UndistortRadialTangential(coefficients, target);
    case Distortion::kEquidistant:
      return UndistortEquidistant(coefficients, target);
    case Distortion::kNone:
      break;
  }
  return target;
}

void StereoRig::Validate(const std::string& what) const {
  cameras[0].Validate(what + ": left camera");
  cameras[1].Validate(what + ": right camera");
  for (const Rigid3& pose : body_from_cam) {
    if (!pose.rotation.coeffs().allFinite() || !pose.translation.allFinite()) {
      throw Error(what + ": the pose of a camera is not finite");
    }
  }
  // Stereo needs a baseline; a micrometre is none.
  constexpr double kNoBaseline = 1e-6;
  if (!(baseline() > kNoBaseline)) {
    throw Error(what + ": both cameras are in the same place, expected a baseline between them");
  }
}

}  // namespace gluevo::vo
