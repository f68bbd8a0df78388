#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/geometry/stereo_rig.h"

/// A simulated stereo rig among random points, observed with noise. Everything is seeded.
namespace gluevo::vo::testing {

inline double Uniform(std::mt19937_64& generator, double low, double high) {
  return low + (high - low) * static_cast<double>(generator() >> 11) * 0x1.0p-53;
}

/// Box and Muller's transform: the same on every standard library.
inline double Gaussian(std::mt19937_64& generator) {
  const double u = 1.0 - Uniform(generator, 0.0, 1.0);
  return std::sqrt(-2.0 * std::log(u)) *
         std::cos(2.0 * std::numbers::pi * Uniform(generator, 0.0, 1.0));
}

inline Eigen::Vector3d UniformVector(std::mt19937_64& generator, double half_size) {
  const double x = Uniform(generator, -half_size, half_size);
  const double y = Uniform(generator, -half_size, half_size);
  return {x, y, Uniform(generator, -half_size, half_size)};
}

/// EuRoC's proportions: 752 x 480, focal length 460, baseline 0.11 m; both cameras turned and
/// shifted against the body so that no extrinsic parameter is trivial.
inline StereoRig SimulatedRig() {
  StereoRig rig;
  for (Camera& camera : rig.cameras) {
    camera = {752, 480, 460.0, 460.0, 375.5, 239.5};
  }
  // The camera looks along the body's x, its image's right is the body's -y.
  Eigen::Matrix3d body_from_cam;
  body_from_cam << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Quaterniond rotation(body_from_cam);
  rig.body_from_cam[0] = {rotation * ExpSo3({0.01, -0.02, 0.015}), {0.05, 0.06, -0.01}};
  rig.body_from_cam[1] = {rotation * ExpSo3({-0.012, 0.008, -0.005}), {0.052, -0.05, -0.008}};
  rig.body_frame = "imu (body)";
  return rig;
}

/// Points on the walls, floor and ceiling of a room around the origin, metres.
inline std::vector<Eigen::Vector3d> RoomPoints(int count, double half_size, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d point = UniformVector(generator, half_size);
    const int axis = static_cast<int>(generator() % 3);
    point[axis] = point[axis] < 0.0 ? -half_size : half_size;
    points.push_back(point);
  }
  return points;
}

/// Projection onto the normalised plane; false outside the image.
inline bool Observe(const StereoRig& rig, int camera, const Rigid3& world_from_body,
                    const Eigen::Vector3d& point_in_world, Eigen::Vector2d& normalized) {
  const Eigen::Vector3d in_cam =
      (world_from_body * rig.body_from_cam[camera]).Inverse() * point_in_world;
  if (in_cam.z() < 0.2) {
    return false;
  }
  normalized = in_cam.head<2>() / in_cam.z();
  const Camera& c = rig.cameras[camera];
  const double x = c.fx * normalized.x() + c.cx;
  const double y = c.fy * normalized.y() + c.cy;
  return x >= 0.0 && y >= 0.0 && x <= c.width - 1.0 && y <= c.height - 1.0;
}

struct SimulationOptions {
  double noise_px = 0.5;       // standard deviation, each axis
  double outlier_share = 0.0;  // observations (left and right) put anywhere in the image
  int max_observations = 150;
  std::uint64_t seed = 1;
};

/// What a front end would see from `world_from_body`; track ids are the indices of the points plus
/// `first_track_id`.
inline TrackedFrame Simulate(const StereoRig& rig, const std::vector<Eigen::Vector3d>& points,
                             const Rigid3& world_from_body, int64_t timestamp_ns,
                             const SimulationOptions& options, int64_t first_track_id = 0) {
  std::mt19937_64 generator(options.seed * 1000003 + static_cast<std::uint64_t>(timestamp_ns));
  TrackedFrame frame;
  frame.timestamp_ns = timestamp_ns;
  const double sigma = options.noise_px / 460.0;
  const auto noise = [&] {
    const double x = sigma * Gaussian(generator);
    return Eigen::Vector2d(x, sigma * Gaussian(generator));
  };
  const auto anywhere = [&] {
    const double x = Uniform(generator, -0.8, 0.8);
    return Eigen::Vector2d(x, Uniform(generator, -0.5, 0.5));
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    Observation observation;
    if (static_cast<int>(frame.observations.size()) >= options.max_observations ||
        !Observe(rig, 0, world_from_body, points[i], observation.left)) {
      continue;
    }
    observation.track_id = first_track_id + static_cast<int64_t>(i);
    observation.has_right = Observe(rig, 1, world_from_body, points[i], observation.right);
    observation.left += noise();
    observation.right += noise();
    if (Uniform(generator, 0.0, 1.0) < options.outlier_share) {
      observation.left = anywhere();
      observation.right = anywhere();
    }
    frame.observations.push_back(observation);
  }
  return frame;
}

/// Plays given frames, in order, whatever the images.
class ScriptedFrontEnd final : public FrontEnd {
 public:
  explicit ScriptedFrontEnd(std::vector<TrackedFrame> frames) : frames_(std::move(frames)) {}
  TrackedFrame Track(const StereoFrame&) override { return frames_.at(next_++); }

 private:
  std::vector<TrackedFrame> frames_;
  std::size_t next_ = 0;
};

}  // namespace gluevo::vo::testing
