#include "gluevo/vo/camera.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

// Value and derivative of a polynomial 1 + c0 x + c1 x^2 + ...
struct Polynomial {
  double value;
  double derivative;
};

Polynomial Evaluate(const double* coefficients, int count, double x) {
  Polynomial result{0.0, 0.0};
  for (int i = count - 1; i >= 0; --i) {
    result.derivative = result.derivative * x + result.value;
    result.value = result.value * x + coefficients[i];
  }
  result.derivative = result.derivative * x + result.value;
  result.value = result.value * x + 1.0;
  return result;
}

// Distorted point (before focal length and centre) and its derivative.
struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

Distorted RadialTangential(const Camera& camera, const Eigen::Vector2d& p) {
  const auto& [k1, k2, p1, p2, k3] = camera.coefficients;
  const double radial_coefficients[] = {k1, k2, k3};
  const double x = p.x();
  const double y = p.y();
  const double r2 = p.squaredNorm();
  const Polynomial radial = Evaluate(radial_coefficients, 3, r2);
  Distorted result;
  result.point = radial.value * p + Eigen::Vector2d(2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                                                    p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y);
  result.jacobian =
      radial.value * Eigen::Matrix2d::Identity() + 2.0 * radial.derivative * p * p.transpose();
  result.jacobian(0, 0) += 2.0 * p1 * y + 6.0 * p2 * x;
  result.jacobian(0, 1) += 2.0 * p1 * x + 2.0 * p2 * y;
  result.jacobian(1, 0) += 2.0 * p1 * x + 2.0 * p2 * y;
  result.jacobian(1, 1) += 6.0 * p1 * y + 2.0 * p2 * x;
  return result;
}

// Image radius of an angle from the optical axis, and its derivative.
Polynomial EquidistantRadius(const Camera& camera, double theta) {
  const double theta2 = theta * theta;
  const Polynomial factor = Evaluate(camera.coefficients.data(), 4, theta2);
  return {theta * factor.value, factor.value + 2.0 * theta2 * factor.derivative};
}

Distorted Equidistant(const Camera& camera, const Eigen::Vector2d& p) {
  const double r = p.norm();
  // Near the centre the camera is a pinhole.
  if (r < 1e-8) {
    return {p, Eigen::Matrix2d::Identity()};
  }
  const Polynomial radius = EquidistantRadius(camera, std::atan(r));
  const double by_r = radius.derivative / (1.0 + r * r);
  const Eigen::Vector2d direction = p / r;
  const Eigen::Matrix2d along = direction * direction.transpose();
  return {radius.value * direction,
          by_r * along + radius.value / r * (Eigen::Matrix2d::Identity() - along)};
}

Distorted DistortPoint(const Camera& camera, const Eigen::Vector2d& p) {
  switch (camera.distortion) {
    case Distortion::kRadialTangential:
      return RadialTangential(camera, p);
    case Distortion::kEquidistant:
      return Equidistant(camera, p);
    case Distortion::kNone:
      break;
  }
  return {p, Eigen::Matrix2d::Identity()};
}

constexpr int kMaxIterations = 50;

Eigen::Vector2d Nowhere() {
  return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
}

Eigen::Vector2d UndistortEquidistant(const Camera& camera, const Eigen::Vector2d& distorted,
                                     double tolerance) {
  const double target = distorted.norm();
  if (target < 1e-8) {
    return distorted;
  }
  double theta = target;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Polynomial radius = EquidistantRadius(camera, theta);
    const double step = (radius.value - target) / radius.derivative;
    theta -= step;
    // Beyond 90 degrees, or where the polynomial turned, there is no point of the plane z = 1.
    if (!(theta > 0.0 && theta < 1.5707) || !(radius.derivative > 0.0)) {
      return Nowhere();
    }
    if (std::abs(step) < tolerance) {
      return std::tan(theta) / target * distorted;
    }
  }
  return Nowhere();
}

Eigen::Vector2d UndistortRadialTangential(const Camera& camera, const Eigen::Vector2d& distorted,
                                          double tolerance) {
  Eigen::Vector2d p = distorted;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Distorted at = RadialTangential(camera, p);
    const Eigen::Vector2d error = at.point - distorted;
    if (error.norm() < tolerance) {
      // On the branch that begins at the centre the map never folds on the way out.
      constexpr int kSteps = 16;
      for (int step = 1; step <= kSteps; ++step) {
        const Eigen::Vector2d inner = p * step / kSteps;
        if (!(RadialTangential(camera, inner).jacobian.determinant() > 0.0)) {
          return Nowhere();
        }
      }
      return p;
    }
    Eigen::Vector2d step = at.jacobian.inverse() * error;
    if (!step.allFinite()) {
      return Nowhere();
    }
    // Halve steps that lead away: far out Newton's first ones may overshoot.
    for (int halvings = 0;
         halvings < 20 &&
         !((RadialTangential(camera, p - step).point - distorted).norm() < error.norm());
         ++halvings) {
      step *= 0.5;
    }
    p -= step;
  }
  return Nowhere();
}

}  // namespace

void Camera::Validate(const std::string& what) const {
  const auto fail = [&](const std::string& problem) { throw Error(what + ": " + problem); };
  if (width < 1 || height < 1) {
    fail("image size " + std::to_string(width) + " x " + std::to_string(height) +
         ", expected positive numbers");
  }
  if (!(fx > 0.0 && fy > 0.0) || !std::isfinite(fx) || !std::isfinite(fy)) {
    fail("focal lengths " + std::to_string(fx) + ", " + std::to_string(fy) +
         ", expected positive numbers");
  }
  if (!std::isfinite(cx) || !std::isfinite(cy)) {
    fail("principal point is not finite");
  }
  for (const double coefficient : coefficients) {
    if (!std::isfinite(coefficient)) {
      fail("distortion coefficients are not finite");
    }
  }
}

Eigen::Vector2d Camera::Project(const Eigen::Vector3d& point_in_cam) const {
  return Distort(point_in_cam.hnormalized());
}

Eigen::Vector2d Camera::Distort(const Eigen::Vector2d& normalized) const {
  const Eigen::Vector2d distorted = DistortPoint(*this, normalized).point;
  return {fx * distorted.x() + cx, fy * distorted.y() + cy};
}

Eigen::Matrix2d Camera::DistortJacobian(const Eigen::Vector2d& normalized) const {
  return Eigen::Vector2d(fx, fy).asDiagonal() * DistortPoint(*this, normalized).jacobian;
}

Eigen::Vector2d Camera::Undistort(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  const double tolerance = 1e-10 / std::max(fx, fy);
  switch (distortion) {
    case Distortion::kRadialTangential:
      return UndistortRadialTangential(*this, distorted, tolerance);
    case Distortion::kEquidistant:
      return UndistortEquidistant(*this, distorted, tolerance);
    case Distortion::kNone:
      break;
  }
  return distorted;
}

void StereoRig::Validate(const std::string& what) const {
  cameras[0].Validate(what + ", left camera");
  cameras[1].Validate(what + ", right camera");
  for (const Rigid3& pose : body_from_cam) {
    if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite()) {
      throw Error(what + ": a camera's pose is not finite");
    }
  }
  if (!(baseline() > 1e-6)) {
    throw Error(what + ": the two cameras are in the same place, expected a stereo pair");
  }
}

}  // namespace gluevo::vo
