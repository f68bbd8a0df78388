#pragma once

#include <cstdint>
#include <vector>

#include "gluevo/vo/inertial/imu_readings.h"
#include "gluevo/vo/inertial/inertial_residual.h"
#include "vo/inertial/inertial_flight.h"
#include "vo/scene.h"
#include "window_problem.h"

/// Windows of a flight with an inertial unit whose biases are constant.
namespace gluevo::vo::testing {

inline const ImuBias kSceneBias = {{0.012, -0.02, 0.008}, {0.08, -0.05, 0.06}};

struct InertialScene {
  static constexpr int kFrames = 8;
  static constexpr int64_t kStepNs = 400'000'000;

  /// Factors integrated with `bias`.
  explicit InertialScene(const ImuBias& bias)
      : flight(5, ImuNoise(), /*is_ideal=*/true, 1), readings(ImuNoise()) {
    std::vector<ImuSample> samples = flight.samples;
    for (ImuSample& sample : samples) {
      sample.angular_velocity += kSceneBias.gyroscope;
      sample.specific_force += kSceneBias.accelerometer;
    }
    readings.Add(samples);
    for (int i = 0; i + 1 < kFrames; ++i) {
      factors.push_back(MakeInertialFactor(readings.Between(TimeOf(i), TimeOf(i + 1), bias)));
    }
  }

  static int64_t TimeOf(int frame) { return 200'000'000 + frame * kStepNs; }
  InertialState TruthOf(int frame) const {
    InertialState state = flight.StateAt(TimeOf(frame));
    state.bias = kSceneBias;
    return state;
  }

  /// Exact views of a room's points; all but the first pose and the views away from the truth.
  WindowProblem Problem(std::uint64_t seed) const {
    std::mt19937_64 generator(seed);
    const StereoRig rig = SimulatedRig();
    WindowProblem problem;
    problem.body_from_cam = rig.body_from_cam;
    problem.weight = 460.0 / 0.5;
    for (int i = 0; i < kFrames; ++i) {
      InertialVector error = InertialVector::Zero();
      if (i > 0) {
        error.head<6>() << UniformVector(generator, 0.02), UniformVector(generator, 0.005);
      }
      error.segment<3>(6) = UniformVector(generator, 0.2);
      const InertialState state = Plus(TruthOf(i), error);
      problem.world_from_body.push_back(state.world_from_body);
      problem.motions.push_back({state.velocity_in_world, {}});
      if (i > 0) {
        problem.measured.push_back(&factors[static_cast<std::size_t>(i) - 1]);
      }
    }
    problem.gravity.first_in_world = TurnedGravity(flight.gravity, {0.05, -0.08});
    for (const Eigen::Vector3d& in_world : RoomPoints(300, 6.0, seed)) {
      WindowProblem::Point point{.anchor = -1,
                                 .first_view = static_cast<int>(problem.views.size())};
      for (int frame = 0; frame < kFrames; ++frame) {
        const Rigid3 pose = TruthOf(frame).world_from_body;
        for (int camera = 0; camera < 2; ++camera) {
          Eigen::Vector2d seen;
          if (!Observe(rig, camera, pose, in_world, seen) || (camera == 1 && point.anchor < 0)) {
            continue;
          }
          if (point.anchor < 0) {
            point.anchor = frame;
            point.position << seen, 1.0 / ((pose * rig.body_from_cam[0]).Inverse() * in_world).z();
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

  InertialFlight flight;
  ImuReadings readings;
  std::vector<InertialFactor> factors;  ///< From each frame to the next.
};

}  // namespace gluevo::vo::testing
