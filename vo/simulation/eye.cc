#include "eye.h"

namespace gluevo::simulation {

std::optional<Eigen::Vector3d> Eye::PointAlong(const Eigen::Vector2d& ray) const {
  if (!ray.allFinite()) return std::nullopt;
  const Eigen::Vector3d direction = world_from_cam_.rotation * ray.homogeneous();
  const std::optional<SurfaceHit> hit = view_.Cast(direction);
  if (!hit) return std::nullopt;
  return world_from_cam_.translation + hit->distance * direction;
}

std::optional<Eigen::Vector2d> Eye::PixelOf(const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector3d point = cam_from_world_ * point_in_world;
  if (!(point.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d ray = point.head<2>() / point.z();
  // Beyond its range a distortion folds the world back into the image.
  if (!(ray.norm() <= widest_)) return std::nullopt;
  const Eigen::Vector2d pixel = camera_.Distort(ray);
  if (!(pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < camera_.width - 0.5 &&
        pixel.y() < camera_.height - 0.5)) {
    return std::nullopt;
  }
  const std::optional<SurfaceHit> hit = view_.Cast(point_in_world - world_from_cam_.translation);
  constexpr double kTolerance = 1e-4;  // metres
  if (!hit || (1.0 - hit->distance) * point.norm() > kTolerance) return std::nullopt;
  return pixel;
}

}  // namespace gluevo::simulation
