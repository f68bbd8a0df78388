#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "path.h"
#include "seen.h"
#include "world.h"

namespace gluevo::simulation {

/// The walls of a room, metres: floor at low.z, ceiling at high.z.
struct RoomPlan {
  Eigen::Vector3d low;
  Eigen::Vector3d high;
};

/// A room around the points, 1.2 m above its floor.
RoomPlan PlanRoom(const std::vector<Eigen::Vector3d>& points, const RoomMargins& margins);

struct RoomStyle {
  double texel_m = 0.005;      ///< Of walls, floor and ceiling.
  double box_texel_m = 0.003;  ///< Of what stands in the room, which is seen from nearer.
  double floor_per_box = 9.0;  ///< Square metres.
  /// Any pattern on any side; else floors have tiles, and the walls differ from one another.
  bool any_cover = false;
  /// Where above 0, what is seen repeats every so many metres along x, but for the two end walls:
  /// the plan's length is a multiple of it. Not with `add_seen`.
  double twin_m = 0.0;
};

/// The room with pillars, crates, standing and hanging panels, all drawn from the seed and kept
/// 0.6 m off the points of `keep_clear`. In halls of more than 2500 square metres of walls, floor
/// and ceiling their texels are coarser than the style says. `add_seen`: adds what will be looked
/// at of a world without textures; the rest is left gray, which is faster. `checkpoint`: see
/// SimulationOptions.
SimulatedWorld MakeRoom(uint64_t seed, const RoomPlan& plan,
                        const std::vector<Eigen::Vector3d>& keep_clear, const RoomStyle& style,
                        int threads,
                        const std::function<void(const SimulatedWorld&, SeenParts*)>& add_seen = {},
                        const std::function<void()>& checkpoint = {});

}  // namespace gluevo::simulation
