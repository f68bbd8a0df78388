#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "texture.h"

namespace gluevo::simulation {

/// An upright box, turned about the vertical. Face 2 * axis + (1 where its outward normal is along
/// +axis); a face's (u, v) are metres along the two other axes, in order, from their lower ends.
struct SimulatedBox {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();     // world, metres
  Eigen::Vector3d half_size = Eigen::Vector3d::Ones();  // metres
  double yaw = 0.0;                                     // radians
  std::array<Texture, 6> faces;

  /// Width and height, metres, along a face's u and v.
  Eigen::Vector2d FaceSize(int face) const;
  Eigen::Vector3d BoxFromWorld(const Eigen::Vector3d& point_in_world) const;
  Eigen::Vector3d WorldFromBox(const Eigen::Vector3d& point_in_box) const;
  /// Distance of a point to the box; 0 inside.
  double Distance(const Eigen::Vector3d& point_in_world) const;
};

/// A room, seen from inside, with boxes in it, seen from outside.
struct SimulatedWorld {
  SimulatedBox room;
  std::vector<SimulatedBox> boxes;
};

/// Where a ray meets the world first.
struct SurfaceHit {
  double distance = 0.0;  ///< In lengths of the ray's direction.
  int box = -1;           ///< -1: the room.
  int face = 0;
  double u = 0.0, v = 0.0;  ///< Metres.
};

/// The world as seen from one place.
class WorldView {
 public:
  WorldView(const SimulatedWorld& world, const Eigen::Vector3d& eye_in_world);

  /// Exact intersection with the room and the boxes; nothing where the eye is outside the room, and
  /// for directions that are not finite. The direction need not have unit length.
  std::optional<SurfaceHit> Cast(const Eigen::Vector3d& direction_in_world) const;

 private:
  struct Placed {
    Eigen::Vector3d eye;  ///< In the box's frame.
    Eigen::Vector3d half_size;
    double cosine = 1.0, sine = 0.0;  ///< Of the yaw.
  };
  static Placed Place(const SimulatedBox& box, const Eigen::Vector3d& eye_in_world);

  Placed room_;
  std::vector<Placed> boxes_;
};

}  // namespace gluevo::simulation
