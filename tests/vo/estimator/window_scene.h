#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "vo/scene.h"
#include "window_problem.h"

/// Windows of a simulated rig among random points.
namespace gluevo::vo::testing {

inline constexpr int kWindowFrames = 8;

inline Rigid3 WindowPoseAt(int frame) {
  const double t = 0.3 * frame;
  return {ExpSo3({0.1 * std::sin(t), 0.05 * t, 0.3 * t}),
          {0.4 * t, 0.2 * std::sin(t), 0.1 * std::cos(t)}};
}

/// A wall of points seen by all frames with noise, a share of them wrong; poses and points start
/// away from the truth.
inline WindowProblem MakeWindowProblem(std::uint64_t seed, double outlier_share) {
  std::mt19937_64 generator(seed);
  const StereoRig rig = SimulatedRig();
  WindowProblem problem;
  problem.body_from_cam = rig.body_from_cam;
  problem.weight = 460.0 / 0.5;
  problem.turn_sigma = 5e-4;
  problem.turn = {1e-4, -2e-4, 5e-5};
  for (int i = 0; i < kWindowFrames; ++i) {
    PoseTangent error;
    error << UniformVector(generator, 0.02), UniformVector(generator, 0.005);
    problem.world_from_body.push_back(i == 0 ? WindowPoseAt(i) : Plus(WindowPoseAt(i), error));
  }
  for (const Eigen::Vector3d& in_world : RoomPoints(500, 6.0, seed)) {
    WindowProblem::Point point{.anchor = -1, .first_view = static_cast<int>(problem.views.size())};
    for (int frame = 0; frame < kWindowFrames; ++frame) {
      for (int camera = 0; camera < 2; ++camera) {
        Eigen::Vector2d seen;
        if (!Observe(rig, camera, WindowPoseAt(frame), in_world, seen) ||
            (camera == 1 && point.anchor < 0)) {
          continue;
        }
        const double noise = Uniform(generator, 0.0, 1.0) < outlier_share ? 20.0 : 0.5;
        seen += noise / 460.0 * Eigen::Vector2d(Gaussian(generator), Gaussian(generator));
        if (point.anchor < 0) {
          const Eigen::Vector3d in_cam =
              (WindowPoseAt(frame) * rig.body_from_cam[0]).Inverse() * in_world;
          point.anchor = frame;
          point.position << seen, (1.0 + 0.1 * Gaussian(generator)) / in_cam.z();
        }
        problem.views.push_back({frame, camera, seen});
      }
    }
    point.end_view = static_cast<int>(problem.views.size());
    if (point.end_view - point.first_view > 2) {
      problem.points.push_back(point);
    }
  }
  return problem;
}

/// Of the first three frames, not far from where they are.
inline PosePrior MakePrior(const WindowProblem& problem) {
  std::mt19937_64 generator(7);
  PosePrior prior;
  prior.frame_ids = {0, 1, 2};
  prior.jacobian.resize(21, 21);
  for (double& value : prior.jacobian.reshaped()) {
    value = Uniform(generator, -30.0, 30.0);
  }
  prior.residual = Eigen::VectorXd::Constant(21, 0.3);
  prior.turn = {2e-4, -3e-4, 5e-5};
  for (int i = 0; i < 3; ++i) {
    PoseTangent step;
    step << UniformVector(generator, 0.01), UniformVector(generator, 0.05);
    prior.world_from_body.push_back(
        Plus(problem.world_from_body[static_cast<std::size_t>(i)], step));
  }
  return prior;
}

inline void SetPrior(const PosePrior& prior, WindowProblem& problem) {
  problem.prior = &prior;
  problem.prior_frames = {0, 1, 2};
}

}  // namespace gluevo::vo::testing
