#include "gluevo/vo/geometry/camera.h"

#include <cmath>

#include "distortion_model.h"
#include "gluevo/nn/error.h"

namespace gluevo::vo {
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
  const DistortionModel& model = ModelOf(distortion);
  if (const std::string_view fault = model.fault != nullptr ? model.fault(coefficients) : "";
      !fault.empty()) {
    throw Error(what + ": " + std::string(model.name) + " camera: " + std::string(fault));
  }
}

Eigen::Vector2d Camera::Project(const Eigen::Vector3d& point_in_cam) const {
  return Distort(point_in_cam.head<2>() / point_in_cam.z());
}

Eigen::Vector2d Camera::Distort(const Eigen::Vector2d& normalized) const {
  const Eigen::Vector2d point = ModelOf(distortion).distort(coefficients, normalized).point;
  return {fx * point.x() + cx, fy * point.y() + cy};
}

Eigen::Matrix2d Camera::DistortJacobian(const Eigen::Vector2d& normalized) const {
  return Eigen::Vector2d(fx, fy).asDiagonal() *
         ModelOf(distortion).distort(coefficients, normalized).jacobian;
}

Eigen::Vector2d Camera::Undistort(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d target((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (!target.allFinite()) {
    return NoPoint();
  }
  return ModelOf(distortion).undistort(coefficients, target);
}

Eigen::Vector2d Camera::CentralFocal() const {
  return DistortJacobian(Eigen::Vector2d::Zero()).diagonal();
}

}  // namespace gluevo::vo
