#include "movers.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "gluevo/nn/error.h"
#include "patterns.h"
#include "random.h"

namespace gluevo::simulation {
namespace {

constexpr double kClearance = 0.45;  // Metres, of the body.
constexpr double kLight = 0.9;       // As bright as the middle of a wall.

/// Where and how a mover passes the camera.
struct Passage {
  double time_s = 0.0;
  vo::Rigid3 world_from_cam;
  Eigen::Vector3d camera_velocity = Eigen::Vector3d::Zero();  // world, m/s
};

/// Of the plane z = 1 that an image shows, distortion aside.
Eigen::Vector2d SizeOfView(const vo::Camera& camera) {
  return {camera.width / camera.fx, camera.height / camera.fy};
}

/// A box whose face towards the camera fills `cover` of its image at the time of the passage.
Mover DrawMover(const Passage& passage, const vo::Camera& camera, double cover,
                RandomStream& random) {
  const double distance = random.Uniform(0.9, 2.0);
  const Eigen::Vector2d view = distance * SizeOfView(camera);
  const double area = cover * view.prod();
  // Wider than high, and within the view.
  const double aspect = random.Uniform(1.0, 2.0);
  const double height = std::min(std::sqrt(area / aspect), 0.9 * view.y());
  const double width = std::min(area / height, 0.9 * view.x());
  const double depth = random.Uniform(0.4, 1.0);
  const Eigen::Matrix3d world_from_cam = passage.world_from_cam.rotation.toRotationMatrix();
  const Eigen::Vector3d forward = world_from_cam.col(2);
  const Eigen::Vector3d ahead = Eigen::Vector3d(forward.x(), forward.y(), 0.0).normalized();
  const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ());

  Mover mover;
  mover.box.half_size = 0.5 * Eigen::Vector3d(depth, width, height);
  mover.box.yaw = std::atan2(ahead.y(), ahead.x()) + random.Uniform(-0.2, 0.2);
  const Eigen::Vector3d place =
      passage.world_from_cam.translation + distance * forward + 0.5 * depth * ahead;
  // With the camera or across its way: what goes along with it is hardest to tell from the scene.
  const double side = random.Index(2) == 0 ? 1.0 : -1.0;
  const double along = random.Uniform(-0.2, 0.5);
  const double across = side * random.Uniform(0.4, 1.2);
  const double up = random.Index(2) == 0 ? 0.0 : random.Uniform(-0.25, 0.25);
  mover.velocity_in_world = random.Uniform(0.5, 1.0) * passage.camera_velocity + along * ahead +
                            across * right + up * Eigen::Vector3d::UnitZ();
  mover.box.center = place - passage.time_s * mover.velocity_in_world;
  return mover;
}

bool KeepsClear(const Mover& mover, const Flight& flight) {
  constexpr double kStepS = 0.05;
  const int steps = static_cast<int>(std::ceil(flight.duration_s / kStepS));
  for (int i = 0; i <= steps; ++i) {
    const double time = flight.duration_s * i / steps;
    if (mover.At(time).Distance(flight.path(time).translation) < kClearance) return false;
  }
  return true;
}

Pattern Cover(const Eigen::Vector2d& size, uint64_t seed) {
  const auto pattern = [&]() -> Pattern {
    switch (seed % 4) {
      case 0:
        return WithPosters(Planks(seed), size.x(), size.y(), 5, seed);
      case 1:
        return WithPosters(Plaster(seed), size.x(), size.y(), 7, seed);
      case 2:
        return Blotches(0.15, seed);
      default:
        return Poster(size.x(), size.y(), seed);
    }
  }();
  return [pattern](double u, double v) { return kLight * pattern(u, v); };
}

}  // namespace

SimulatedBox Mover::At(double time_s) const {
  SimulatedBox moved = box;
  moved.center += time_s * velocity_in_world;
  return moved;
}

std::vector<Mover> MakeMovers(uint64_t seed, int count, double cover, const Flight& flight,
                              const vo::StereoRig& rig, double texel_m, int threads,
                              const std::function<void()>& checkpoint) {
  constexpr int kAttempts = 1000;
  std::vector<Mover> movers;
  for (int i = 0; i < count; ++i) {
    RandomStream random(Hash(seed, i));
    const double share = (i + random.Uniform(0.3, 0.7)) / count;
    const double time = share * flight.duration_s;
    const Motion motion = MotionAt(flight.path, time);
    const Passage passage{time, motion.world_from_body * rig.body_from_cam[0],
                          motion.velocity_in_world};
    int attempt = 0;
    Mover mover = DrawMover(passage, rig.cameras[0], cover, random);
    while (!KeepsClear(mover, flight)) {
      if (++attempt == kAttempts) {
        throw Error("simulated movers: no way past the body at " + std::to_string(time) +
                    " s that keeps clear of it, expected fewer of them or another seed");
      }
      mover = DrawMover(passage, rig.cameras[0], cover, random);
    }
    for (int face = 0; face < 6; ++face) {
      const Eigen::Vector2d size = mover.box.FaceSize(face);
      mover.box.faces[face] = Texture(size.x(), size.y(), texel_m, Cover(size, Hash(seed, i, face)),
                                      threads, checkpoint);
    }
    movers.push_back(std::move(mover));
  }
  return movers;
}

SimulatedWorld WorldAt(const SimulatedWorld& world, const std::vector<Mover>& movers,
                       double time_s) {
  SimulatedWorld moved = world;
  for (const Mover& mover : movers) moved.boxes.push_back(mover.At(time_s));
  return moved;
}

}  // namespace gluevo::simulation
