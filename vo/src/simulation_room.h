#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "simulation_world.h"

namespace gluevo::vo {

/// The walls of a room, metres: floor at low.z, ceiling at high.z.
struct RoomPlan {
  Eigen::Vector3d low;
  Eigen::Vector3d high;
};

/// A room around the points: `side_margin` metres to the walls, 1.2 m to the floor and 1.6 m to the
/// ceiling.
RoomPlan PlanRoom(const std::vector<Eigen::Vector3d>& points, double side_margin);

/// The room with pillars, crates, standing and hanging panels, about one for 9 square metres of
/// floor, all drawn from the seed and kept 0.6 m off the points of `keep_clear`; textures in texels
/// of `texel_m` metres (coarser on the walls of rooms above 2000 square metres).
SimulatedWorld MakeRoom(uint64_t seed, const RoomPlan& plan,
                        const std::vector<Eigen::Vector3d>& keep_clear, double texel_m,
                        int threads);

}  // namespace gluevo::vo
