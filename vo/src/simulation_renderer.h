#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "gluevo/vo/camera.h"
#include "simulation_random.h"
#include "simulation_world.h"

namespace gluevo::vo {

/// Ray casts what the cameras of a rig see, with four rays a pixel through the exact inverse of
/// the cameras' distortion (kept as a table) and trilinear textures.
class Renderer {
 public:
  /// The world must outlive the renderer. `noise` as in SimulationOptions.
  Renderer(const StereoRig& rig, const SimulatedWorld& world, double noise, int threads);

  /// CV_8UC1. The noise is drawn from `noise_seed` alone.
  cv::Mat Render(int camera, const Rigid3& world_from_body, uint64_t noise_seed) const;

  /// The point of the world, metres, that is seen at a pixel; nothing from outside the room.
  std::optional<Eigen::Vector3d> PointAt(int camera, const Rigid3& world_from_body,
                                         const Eigen::Vector2d& pixel) const;

 private:
  static constexpr int kTile = 16;    ///< Pixels; a tile's rays share one list of boxes.
  static constexpr int kSamples = 4;  ///< Rays a pixel, 2 x 2.

  struct Tile {
    int left = 0, top = 0, right = 0, bottom = 0;
    Eigen::Vector3d axis_in_cam;
    double half_angle = 0.0;
  };
  struct View {
    std::vector<Eigen::Vector2f> rays;  ///< Normalised plane: row, column, sample.
    std::vector<Tile> tiles;
  };

  static View MakeView(const Camera& camera, int threads);
  float Shade(const WorldView& world, const Eigen::Vector3d& direction_in_world,
              const std::vector<int>& boxes, double sample_angle) const;

  StereoRig rig_;
  const SimulatedWorld& world_;
  float noise_;
  NormalTable normal_;
  std::array<View, 2> views_;
};

}  // namespace gluevo::vo
