#pragma once

#include <Eigen/Core>
#include <optional>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/geometry/camera.h"
#include "world.h"

namespace gluevo::simulation {

/// Exact correspondences between one camera's image and the world, in double precision.
class Eye {
 public:
  /// `widest` is the length, on the plane z = 1, of the longest ray through the image.
  Eye(const SimulatedWorld& world, const vo::Camera& camera, double widest,
      const vo::Rigid3& world_from_cam)
      : camera_(camera),
        widest_(widest),
        world_from_cam_(world_from_cam),
        cam_from_world_(world_from_cam.Inverse()),
        view_(world, world_from_cam.translation) {}

  /// The point of the world, metres, that is seen at a pixel; nothing where the camera has no ray
  /// and from outside the room.
  std::optional<Eigen::Vector3d> PointAt(const Eigen::Vector2d& pixel) const {
    return PointAlong(camera_.Undistort(pixel));
  }
  /// The same by the pixel's ray on the plane z = 1, which Camera::Undistort gives.
  std::optional<Eigen::Vector3d> PointAlong(const Eigen::Vector2d& ray) const;

  /// The pixel that shows a point of a surface; nothing where that is outside the image, or where
  /// something more than 0.1 mm nearer hides the point.
  std::optional<Eigen::Vector2d> PixelOf(const Eigen::Vector3d& point_in_world) const;

 private:
  vo::Camera camera_;
  double widest_;
  vo::Rigid3 world_from_cam_;
  vo::Rigid3 cam_from_world_;
  WorldView view_;
};

}  // namespace gluevo::simulation
