#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "simulation_patterns.h"
#include "simulation_random.h"
#include "simulation_world.h"

namespace gluevo::vo {
namespace {

constexpr double kLength = 12.0;
constexpr double kWidth = 9.0;
constexpr double kHeight = 3.4;
constexpr double kClearance = 0.6;

/// Diffuse light of four lamps under the ceiling, and of all walls together.
double Light(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  double light = 0.6;
  for (const double x : {-3.0, 3.0}) {
    for (const double y : {-2.2, 2.2}) {
      const Eigen::Vector3d to_lamp = Eigen::Vector3d(x, y, kHeight - 0.3) - point;
      const double square = to_lamp.squaredNorm();
      light += 0.9 * std::max(0.0, normal.dot(to_lamp)) / std::sqrt(square) / (1.0 + 0.4 * square);
    }
  }
  return std::min(light, 1.35);
}

/// What covers a face of width x height metres.
using Cover = std::function<Pattern(int face, double width, double height)>;

/// Bakes the faces of a box. `inward`: it is seen from inside.
SimulatedBox MakeBox(const Eigen::Vector3d& center, const Eigen::Vector3d& half_size, double yaw,
                     bool inward) {
  SimulatedBox box;
  box.center = center;
  box.half_size = half_size;
  box.yaw = inward ? 0.0 : yaw;
  return box;
}

void Bake(SimulatedBox* box, bool inward, const Cover& cover, double texel_m, int threads) {
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const int u_axis = axis == 0 ? 1 : 0;
    const int v_axis = axis == 2 ? 1 : 2;
    const double side = face % 2 == 1 ? 1.0 : -1.0;
    Eigen::Vector3d corner = -box->half_size;
    corner[axis] = side * box->half_size[axis];
    // The underside of what stands on the floor is never seen.
    if (!inward && face == 4 && box->WorldFromBox(corner).z() < 1e-6) continue;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    normal[axis] = inward ? -side : side;
    normal = box->WorldFromBox(normal) - box->center;
    const double width = 2.0 * box->half_size[u_axis];
    const double height = 2.0 * box->half_size[v_axis];
    const Pattern pattern = cover(face, width, height);
    const Pattern lit = [&](double u, double v) {
      Eigen::Vector3d point = corner;
      point[u_axis] += u;
      point[v_axis] += v;
      return pattern(u, v) * Light(box->WorldFromBox(point), normal);
    };
    box->faces[face] = Texture(width, height, texel_m, lit, threads);
  }
}

Pattern RoomFace(int face, double width, double height, uint64_t seed) {
  const uint64_t own = Hash(seed, 100, face);
  switch (face) {
    case 0:
      return WithPosters(Bricks(own), width, height, 12, own);
    case 1:
      return WithPosters(Plaster(own), width, height, 18, own);
    case 2:
      return WithPosters(Planks(own), width, height, 18, own);
    case 3:
      return WithPosters(Blotches(0.5, own), width, height, 22, own);
    case 4:
      return Tiles(0.4, own);
    default:
      return CeilingPanels(own);
  }
}

Pattern CrateFace(double width, double height, uint64_t seed) {
  switch (seed % 6) {
    case 0:
      return WithPosters(Planks(seed), width, height, 3, seed);
    case 1:
      return Blotches(0.18, seed);
    case 2:
      return Bricks(seed);
    case 3:
      return Tiles(0.13, seed);
    default:
      return Poster(width, height, seed);
  }
}

Pattern PanelFace(double width, double height, uint64_t seed) {
  return WithPosters(seed % 2 == 0 ? Plaster(seed) : Blotches(0.12, seed), width, height, 6, seed);
}

/// A box somewhere in the hall, of one of a few kinds.
SimulatedBox DrawBox(int kind, RandomStream* random) {
  Eigen::Vector3d half_size;
  double bottom = 0.0;
  switch (kind) {
    case 0:  // A pillar.
      half_size = {random->Uniform(0.18, 0.32), random->Uniform(0.18, 0.32), kHeight / 2.0};
      break;
    case 1:  // A standing panel.
      half_size = {random->Uniform(0.5, 1.1), 0.03, random->Uniform(0.7, 1.1)};
      break;
    case 2:  // A hanging panel.
      half_size = {random->Uniform(0.5, 0.9), 0.03, random->Uniform(0.25, 0.4)};
      bottom = kHeight - 0.05 - 2.0 * half_size.z();
      break;
    default:  // A crate.
      half_size = {random->Uniform(0.25, 0.6), random->Uniform(0.25, 0.6),
                   random->Uniform(0.25, 0.75)};
  }
  const double margin = half_size.head<2>().norm() + 0.05;
  const double x = random->Uniform(margin - kLength / 2.0, kLength / 2.0 - margin);
  const double y = random->Uniform(margin - kWidth / 2.0, kWidth / 2.0 - margin);
  return MakeBox({x, y, bottom + half_size.z()}, half_size, random->Uniform(0.0, std::numbers::pi),
                 false);
}

bool IsFree(const SimulatedBox& box, const std::vector<SimulatedBox>& others,
            const std::vector<Eigen::Vector3d>& keep_clear) {
  const auto far_from = [&](const SimulatedBox& other) {
    return (box.center - other.center).head<2>().norm() >
           box.half_size.head<2>().norm() + other.half_size.head<2>().norm();
  };
  return std::all_of(others.begin(), others.end(), far_from) &&
         std::all_of(keep_clear.begin(), keep_clear.end(), [&](const Eigen::Vector3d& point) {
           return box.Distance(point) > kClearance;
         });
}

}  // namespace

SimulatedWorld MakeHall(uint64_t seed, const std::vector<Eigen::Vector3d>& keep_clear,
                        double texel_m, int threads) {
  SimulatedWorld world;
  world.room =
      MakeBox({0.0, 0.0, kHeight / 2.0}, {kLength / 2.0, kWidth / 2.0, kHeight / 2.0}, 0.0, true);
  Bake(
      &world.room, true,
      [&](int face, double width, double height) { return RoomFace(face, width, height, seed); },
      texel_m, threads);
  RandomStream random(Hash(seed, 1));
  for (const int kind : {0, 0, 1, 1, 1, 2, 2, 3, 3, 3, 3, 3}) {
    // A draw in a thousand fits in the worst of halls; one that never fits is left out.
    for (int attempt = 0; attempt < 1000; ++attempt) {
      SimulatedBox box = DrawBox(kind, &random);
      if (!IsFree(box, world.boxes, keep_clear)) continue;
      const uint64_t own = Hash(seed, 2, world.boxes.size());
      Bake(
          &box, false,
          [&](int face, double width, double height) {
            return kind == 1 || kind == 2 ? PanelFace(width, height, Hash(own, face))
                                          : CrateFace(width, height, Hash(own, face));
          },
          texel_m, threads);
      world.boxes.push_back(std::move(box));
      break;
    }
  }
  return world;
}

}  // namespace gluevo::vo
