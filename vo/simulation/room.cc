#include "room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

#include "light.h"
#include "noise.h"
#include "patterns.h"
#include "random.h"

namespace gluevo::simulation {
namespace {

constexpr double kClearance = 0.6;

/// What covers a face of width x height metres.
using Cover = std::function<Pattern(int face, double width, double height)>;

SimulatedBox MakeBox(const Eigen::Vector3d& center, const Eigen::Vector3d& half_size, double yaw) {
  SimulatedBox box;
  box.center = center;
  box.half_size = half_size;
  box.yaw = yaw;
  return box;
}

/// Bakes the faces of a box, or what is `seen` of them. `index` -1: it is the room, seen from
/// inside.
void Bake(SimulatedBox* box, int index, const Cover& cover, const Light& light,
          const std::optional<SeenParts>& seen, double floor_z, double texel_m, int threads,
          const std::function<void()>& checkpoint) {
  const bool inward = index < 0;
  for (int face = 0; face < 6; ++face) {
    const SeenParts::Face* const part = seen ? &seen->Of(index, face) : nullptr;
    if (part != nullptr && !part->any()) continue;
    const int axis = face / 2;
    const int u_axis = axis == 0 ? 1 : 0;
    const int v_axis = axis == 2 ? 1 : 2;
    const double side = face % 2 == 1 ? 1.0 : -1.0;
    Eigen::Vector3d corner = -box->half_size;
    corner[axis] = side * box->half_size[axis];
    // The underside of what stands on the floor is never seen.
    if (!inward && face == 4 && box->WorldFromBox(corner).z() < floor_z + 1e-6) continue;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    normal[axis] = inward ? -side : side;
    normal = box->WorldFromBox(normal) - box->center;
    const Eigen::Vector2d size = box->FaceSize(face);
    const double width = size.x();
    const double height = size.y();
    const Pattern pattern = cover(face, width, height);
    const LightMap light_map(width, height, [&](double u, double v) {
      Eigen::Vector3d point = corner;
      point[u_axis] += u;
      point[v_axis] += v;
      return light.At(box->WorldFromBox(point), normal);
    });
    const Pattern lit = [&](double u, double v) {
      return part == nullptr || part->At(u, v) ? pattern(u, v) * light_map.At(u, v) : 0.5;
    };
    box->faces[face] = Texture(width, height, texel_m, lit, threads, checkpoint);
  }
}

Pattern RoomFace(int face, double width, double height, uint64_t seed) {
  const uint64_t own = Hash(seed, 100, face);
  const auto posters = [&](double each_m2) {
    return std::clamp(static_cast<int>(width * height / each_m2), 4, 80);
  };
  if (face == 4) return Tiles(0.4, own);
  if (face == 5) return CeilingPanels(own);
  // The four walls have different covers, dealt by the seed; in one room of three, one of them is
  // papered with a pattern that repeats.
  const int deal = face + static_cast<int>(Hash(seed, 101) % 4);
  if (Hash(seed, 102) % 3 == 0 && deal % 4 == 3) {
    const double period = 0.4 + 0.4 * Unit(Hash(seed, 103));
    return WithPosters(Mirrored(Poster(period, period, own), period, period), width, height,
                       posters(4.0), own);
  }
  switch (deal % 4) {
    case 0:
      return WithPosters(Bricks(own), width, height, posters(2.5), own);
    case 1:
      return WithPosters(Plaster(own), width, height, posters(1.8), own);
    case 2:
      return WithPosters(Planks(own), width, height, posters(1.8), own);
    default:
      return WithPosters(Blotches(0.5, own), width, height, posters(1.5), own);
  }
}

Pattern AnyFace(double width, double height, uint64_t seed) {
  RandomStream random(Hash(seed, 1));
  const double size = random.Uniform(0.1, 0.6);
  const auto background = [&]() -> Pattern {
    switch (random.Index(8)) {
      case 0:
        return Bricks(seed);
      case 1:
        return Plaster(seed);
      case 2:
        return Planks(seed);
      case 3:
        return Blotches(size, seed);
      case 4:
        return Tiles(size, seed);
      case 5:
        return CeilingPanels(seed);
      case 6:
        return Mirrored(Poster(size + 0.2, size + 0.2, seed), size + 0.2, size + 0.2);
      default:
        return Poster(width, height, seed);
    }
  };
  const int posters = static_cast<int>(random.Uniform(0.0, 0.8) * width * height);
  return WithPosters(background(), width, height, posters, seed);
}

Pattern CrateFace(double width, double height, uint64_t seed) {
  switch (seed % 7) {
    case 0:
      return WithPosters(Planks(seed), width, height, 3, seed);
    case 1:
      return Blotches(0.18, seed);
    case 2:
      return Bricks(seed);
    case 3:
      return Tiles(0.13, seed);
    case 4:
      return Mirrored(Poster(0.3, 0.3, seed), 0.3, 0.3);
    default:
      return Poster(width, height, seed);
  }
}

Pattern PanelFace(double width, double height, uint64_t seed) {
  return WithPosters(seed % 2 == 0 ? Plaster(seed) : Blotches(0.12, seed), width, height, 6, seed);
}

/// The kinds of boxes, in the order in which a room is furnished.
enum class Kind { kCrate, kStandingPanel, kPillar, kHangingPanel };
constexpr std::array kFurniture = {Kind::kCrate,         Kind::kStandingPanel, Kind::kPillar,
                                   Kind::kCrate,         Kind::kHangingPanel,  Kind::kCrate,
                                   Kind::kStandingPanel, Kind::kCrate,         Kind::kPillar,
                                   Kind::kStandingPanel, Kind::kCrate,         Kind::kHangingPanel};

/// A box somewhere in the room.
SimulatedBox DrawBox(Kind kind, const RoomPlan& plan, RandomStream* random) {
  const Eigen::Vector3d size = plan.high - plan.low;
  Eigen::Vector3d half_size = Eigen::Vector3d::Zero();
  double bottom = plan.low.z();
  switch (kind) {
    case Kind::kPillar:
      half_size = {random->Uniform(0.18, 0.32), random->Uniform(0.18, 0.32), size.z() / 2.0};
      break;
    case Kind::kStandingPanel:
      half_size = {random->Uniform(0.5, 1.1), 0.03, random->Uniform(0.7, 1.1)};
      break;
    case Kind::kHangingPanel:
      half_size = {random->Uniform(0.5, 0.9), 0.03, random->Uniform(0.25, 0.4)};
      bottom = plan.high.z() - 0.05 - 2.0 * half_size.z();
      break;
    case Kind::kCrate:
      half_size = {random->Uniform(0.25, 0.6), random->Uniform(0.25, 0.6),
                   random->Uniform(0.25, 0.75)};
  }
  const double margin = half_size.head<2>().norm() + 0.05;
  const double x = random->Uniform(plan.low.x() + margin, plan.high.x() - margin);
  const double y = random->Uniform(plan.low.y() + margin, plan.high.y() - margin);
  return MakeBox({x, y, bottom + half_size.z()}, half_size, random->Uniform(0.0, std::numbers::pi));
}

/// The box, and its likes in the other parts of a room that repeats.
std::vector<SimulatedBox> WithTwins(const SimulatedBox& box, const RoomPlan& plan, double twin_m) {
  std::vector<SimulatedBox> boxes = {box};
  const int parts =
      twin_m > 0.0 ? static_cast<int>(std::lround((plan.high - plan.low).x() / twin_m)) : 1;
  for (int part = 1; part < parts; ++part) {
    boxes.push_back(box);
    boxes.back().center.x() += part * twin_m;
  }
  return boxes;
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

RoomPlan PlanRoom(const std::vector<Eigen::Vector3d>& points, const RoomMargins& margins) {
  constexpr double kAboveFloor = 1.2;
  RoomPlan plan{points.front(), points.front()};
  for (const Eigen::Vector3d& point : points) {
    plan.low = plan.low.cwiseMin(point);
    plan.high = plan.high.cwiseMax(point);
  }
  plan.low -= Eigen::Vector3d(margins.side, margins.side, kAboveFloor);
  plan.high += Eigen::Vector3d(margins.ahead, margins.side, margins.above);
  return plan;
}

SimulatedWorld MakeRoom(uint64_t seed, const RoomPlan& plan,
                        const std::vector<Eigen::Vector3d>& keep_clear, const RoomStyle& style,
                        int threads,
                        const std::function<void(const SimulatedWorld&, SeenParts*)>& add_seen,
                        const std::function<void()>& checkpoint) {
  const Eigen::Vector3d size = plan.high - plan.low;
  const double walls = 2.0 * (size.x() * size.y() + (size.x() + size.y()) * size.z());
  // A hall as large as a stadium gets coarser texels instead of more memory than machines have.
  constexpr double kMostTexels = 1.5e8;
  const double room_texel_m = std::max(style.texel_m, std::sqrt(walls / kMostTexels));
  SimulatedWorld world;
  world.room = MakeBox(0.5 * (plan.low + plan.high), 0.5 * size, 0.0);
  RandomStream random(Hash(seed, 1));
  std::vector<Kind> kinds;
  std::vector<std::size_t> originals;  // Of each box the one that it looks like.
  RoomPlan drawn = plan;
  if (style.twin_m > 0.0) drawn.high.x() = plan.low.x() + style.twin_m;
  const double floor = (drawn.high - drawn.low).x() * size.y();
  const int count = std::clamp(static_cast<int>(floor / style.floor_per_box), 4, 100);
  for (int i = 0; i < count; ++i) {
    const Kind kind = kFurniture[static_cast<std::size_t>(i) % kFurniture.size()];
    // A draw in a thousand fits in the worst of rooms; one that never fits is left out.
    for (int attempt = 0; attempt < 1000; ++attempt) {
      const std::vector<SimulatedBox> boxes =
          WithTwins(DrawBox(kind, drawn, &random), plan, style.twin_m);
      if (!std::all_of(boxes.begin(), boxes.end(), [&](const SimulatedBox& box) {
            return IsFree(box, world.boxes, keep_clear);
          })) {
        continue;
      }
      originals.insert(originals.end(), boxes.size(), world.boxes.size());
      kinds.insert(kinds.end(), boxes.size(), kind);
      world.boxes.insert(world.boxes.end(), boxes.begin(), boxes.end());
      break;
    }
  }

  std::optional<SeenParts> seen;
  if (add_seen) {
    seen.emplace(world, std::max(room_texel_m, style.box_texel_m));
    add_seen(world, &*seen);
  }
  const Light light(plan);
  Bake(
      &world.room, -1,
      [&](int face, double width, double height) {
        Pattern pattern = style.any_cover ? AnyFace(width, height, Hash(seed, 104, face))
                                          : RoomFace(face, width, height, seed);
        // Along x lies the u of all faces but those at its ends.
        if (style.twin_m <= 0.0 || face < 2) return pattern;
        return Pattern([pattern, twin_m = style.twin_m](double u, double v) {
          return pattern(std::fmod(u, twin_m), v);
        });
      },
      light, seen, plan.low.z(), room_texel_m, threads, checkpoint);
  for (std::size_t i = 0; i < world.boxes.size(); ++i) {
    if (originals[i] != i) {
      world.boxes[i].faces = world.boxes[originals[i]].faces;
      continue;
    }
    const uint64_t own = Hash(seed, 2, i);
    const bool panel = kinds[i] == Kind::kStandingPanel || kinds[i] == Kind::kHangingPanel;
    Bake(
        &world.boxes[i], static_cast<int>(i),
        [&](int face, double width, double height) {
          return panel ? PanelFace(width, height, Hash(own, face))
                       : CrateFace(width, height, Hash(own, face));
        },
        light, seen, plan.low.z(), style.box_texel_m, threads, checkpoint);
  }
  return world;
}

}  // namespace gluevo::simulation
