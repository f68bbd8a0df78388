#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/simulation/pairs.h"
#include "renderer.h"

namespace gluevo::simulation {

/// Of a training room.
inline constexpr int kViews = 8;

/// What a room's group holds.
struct TrainingRoom {
  std::vector<uint8_t> images;
  std::vector<float> depth;
  std::vector<double> world_from_cam;
  std::vector<double> cameras;
  std::vector<double> boxes;
  std::vector<int32_t> pairs;
  std::vector<float> overlap;
  std::vector<float> correspondences;
};

/// The rig of a file: EuRoC's with another focal length, more or less distortion, another baseline.
vo::StereoRig DrawRig(const PairOptions& options, uint64_t seed);

/// Every eighth pixel: x y, x y, ...
std::vector<float> GridOf(const PairOptions& options);

/// Rays of the grid's pixels, of each camera.
using GridRays = std::array<std::vector<Eigen::Vector2d>, 2>;
GridRays RaysOf(const std::vector<float>& grid, const vo::StereoRig& rig);

TrainingRoom MakeTrainingRoom(const PairOptions& options, const Renderer& renderer,
                              const GridRays& rays, uint64_t seed);

}  // namespace gluevo::simulation
