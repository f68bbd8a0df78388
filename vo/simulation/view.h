#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/geometry/camera.h"
#include "world.h"

namespace gluevo::simulation {

/// A face of a box as one camera sees it. With the ray (x, y, 1) of the camera, the three linear
/// forms a = `across`, u = `along_u`, v = `along_v` give the depth `distance` / a along the optical
/// axis and the place (u / a, v / a) on the face, metres: a homography. The ray meets the face's
/// plane in front of the eye where a > 0.
struct FaceView {
  using Form = std::array<float, 3>;  ///< Value at (x, y, 1): f[0] x + f[1] y + f[2].
  Form across = {};
  Form along_u = {};
  Form along_v = {};
  float distance = 0.0F;
  float width = 0.0F;
  float height = 0.0F;
  /// log2 of the homography's determinant: an area of the plane z = 1 is larger by
  /// determinant / a^3 on the face.
  float log2_scale = 0.0F;
  const Texture* texture = nullptr;
  int box = -1;  ///< -1: the room.
  int face = 0;
};

inline float ValueAt(const FaceView::Form& form, float x, float y) {
  return form[0] * x + form[1] * y + form[2];
}

/// The faces that are turned towards a camera, the room's first (those that any ray meets; none
/// where the camera is outside the room).
std::vector<FaceView> FacesInView(const SimulatedWorld& world, const vo::Rigid3& world_from_cam);

/// The rays of a camera through places in its pixels, in tiles.
struct RayGrid {
  static constexpr int kTile = 16;  ///< Pixels a side.

  struct Tile {
    int left = 0, top = 0, right = 0, bottom = 0;
    Eigen::Vector2f low, high;  ///< The box of its rays on the plane z = 1.
    bool whole = true;          ///< Every pixel has its rays.
    float log2_sample = 0.0F;   ///< log2 of the side of a sample's square on the plane z = 1.
  };

  /// `samples_per_side` squared rays a pixel, through the exact inverse of the camera's distortion.
  RayGrid(const vo::Camera& camera, int samples_per_side, int threads);

  int width = 0;
  int samples = 1;                    ///< Rays a pixel.
  std::vector<Eigen::Vector2f> rays;  ///< Row, column, sample; NaN where the camera has no ray.
  std::vector<Tile> tiles;
  double widest = 0.0;  ///< Length of the longest ray on the plane z = 1, and a little more.

  const Eigen::Vector2f* RaysOf(int x, int y) const {
    return &rays[(static_cast<std::size_t>(y) * width + x) * samples];
  }
};

/// log2 of the side of a sample's footprint on a face, metres, for a ray with a = `across`. It is
/// longer along the slope than across: the geometric mean, which is the root of its area, is where
/// blur and aliasing balance.
inline float Log2Footprint(const FaceView& face, float across, const RayGrid::Tile& tile) {
  return 0.5F * (face.log2_scale - 3.0F * std::log2(across)) + tile.log2_sample;
}

/// The faces that rays of a tile can meet, of those of a camera's view.
struct TileFaces {
  /// Sorts the faces out for a tile; `faces` is FacesInView's.
  void Find(const std::vector<FaceView>& faces, const RayGrid::Tile& tile);

  /// The face that a ray meets first; nothing for a ray that is NaN or where there is no room.
  const FaceView* Meet(const Eigen::Vector2f& ray) const;

  std::vector<const FaceView*> room;
  std::vector<const FaceView*> boxes;
  /// The one face that all rays of the tile meet, where that is known.
  const FaceView* only = nullptr;
};

}  // namespace gluevo::simulation
