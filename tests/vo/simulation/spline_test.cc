#include "spline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "imu.h"

namespace gluevo::simulation {
namespace {

vo::Trajectory Sampled(const SimulationPath& path, double rate_hz, double duration_s) {
  vo::Trajectory trajectory;
  for (int i = 0; i <= duration_s * rate_hz; ++i) {
    const double time = i / rate_hz;
    trajectory.push_back({1'400'000'000'000'000'000 + std::llround(time * 1e9), path(time)});
  }
  return trajectory;
}

std::string ErrorOf(const vo::Trajectory& trajectory) {
  try {
    const TrajectorySpline spline(trajectory, "flight.txt");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(TrajectorySplineTest, FollowsASmoothPath) {
  const SimulationPath path = MakeSimulationPath("hall_loop");
  for (const double rate : {200.0, 20.0, 10.0}) {
    const TrajectorySpline spline(Sampled(path, rate, 10.0), "flight.txt");
    EXPECT_NEAR(spline.duration_s(), 10.0, 1e-9);
    for (int i = 0; 0.037 * i <= 10.0; ++i) {
      const double time = 0.037 * i;
      EXPECT_LT((spline.At(time).translation - path(time).translation).norm(), 1e-3) << time;
      EXPECT_LT(spline.At(time).rotation.angularDistance(path(time).rotation), 1e-3) << time;
    }
  }
}

TEST(TrajectorySplineTest, HasContinuousDerivatives) {
  // A recording with a jump of 5 cm and one of the quaternion's sign, as files have them.
  vo::Trajectory trajectory = Sampled(MakeSimulationPath("hall_loop"), 50.0, 6.0);
  for (std::size_t i = 150; i < trajectory.size(); ++i) {
    trajectory[i].world_from_body.translation.x() += 0.05;
    trajectory[i].world_from_body.rotation.coeffs() *= -1.0;
  }
  const TrajectorySpline spline(trajectory, "flight.txt");
  const SimulationPath path = [&](double time) { return spline.At(time); };
  // The path's own third derivative is below 3 m/s^3. A step smoothed at 4 Hz (25 rad/s) has one of
  // about 0.05 * 25^3 = 800 m/s^3: 0.8 m/s^2 in 1 ms. A step of the acceleration would be tens.
  Motion last = MotionAt(path, 1.0);
  for (int i = 1; i < 4000; ++i) {
    const double time = 1.0 + 0.001 * i;
    const Motion next = MotionAt(path, time);
    EXPECT_LT((next.acceleration_in_world - last.acceleration_in_world).norm(), 1.0) << time;
    EXPECT_LT((next.angular_velocity_in_body - last.angular_velocity_in_body).norm(), 0.02) << time;
    last = next;
  }
}

// The sensor's samples of a splined recording lead back to it, as an estimator will integrate them:
// noise of n a root hertz becomes n sqrt(T^3 / 3) metres after T s of accelerations, and
// 9.81 n' sqrt(T^5 / 20) through the attitude; biases are known here, but walk by
// w sqrt(T) a second, w sqrt(T^5 / 20) metres. Four deviations of the sum of variances.
TEST(TrajectorySplineTest, InertialSamplesIntegrateBackWithinTheirNoise) {
  const TrajectorySpline spline(Sampled(MakeSimulationPath("hall_loop"), 20.0, 12.0), "flight.txt");
  const SimulationPath path = [&](double time) { return spline.At(time + 3.0); };
  constexpr double kSeconds = 6.0;
  const vo::ImuNoise noise;
  const auto samples = SimulateImu(path, static_cast<int>(kSeconds) * kImuRateHz + 1, noise, 11);
  Eigen::Quaterniond rotation = path(0.0).rotation;
  Eigen::Vector3d position = path(0.0).translation;
  Eigen::Vector3d velocity = MotionAt(path, 0.0).velocity_in_world;
  constexpr double kStep = 1.0 / kImuRateHz;
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    const auto gyroscope = [&](std::size_t k) {
      return Eigen::Vector3d(samples[k].angular_velocity - samples[0].gyroscope_bias);
    };
    const auto force = [&](std::size_t k) {
      return Eigen::Vector3d(samples[k].specific_force - samples[0].accelerometer_bias);
    };
    const Eigen::Vector3d turn = 0.5 * (gyroscope(i) + gyroscope(i + 1)) * kStep;
    const Eigen::Quaterniond next =
        rotation * Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
    const Eigen::Vector3d acceleration = 0.5 * (rotation * force(i) + next * force(i + 1)) -
                                         Eigen::Vector3d(0.0, 0.0, kSimulationGravity);
    position += velocity * kStep + 0.5 * acceleration * kStep * kStep;
    velocity += acceleration * kStep;
    rotation = next;
  }
  const double t3 = std::pow(kSeconds, 3) / 3.0;
  const double t5 = std::pow(kSeconds, 5) / 20.0;
  const double variance = std::pow(noise.accelerometer_density, 2) * t3 +
                          std::pow(noise.accelerometer_random_walk, 2) * t5 +
                          std::pow(9.81 * noise.gyroscope_density, 2) * t5;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(position[axis], path(kSeconds).translation[axis], 4.0 * std::sqrt(variance));
  }
  const double turn_variance =
      std::pow(noise.gyroscope_density, 2) * kSeconds +
      std::pow(noise.gyroscope_random_walk, 2) * std::pow(kSeconds, 3) / 3.0;
  EXPECT_LT(rotation.angularDistance(path(kSeconds).rotation),
            4.0 * std::sqrt(3.0 * turn_variance));
}

TEST(TrajectorySplineTest, RefusesWhatCannotBeFlown) {
  const SimulationPath still = [](double) { return vo::Rigid3(); };
  EXPECT_EQ(ErrorOf(Sampled(still, 10.0, 3.0)), "");
  EXPECT_NE(ErrorOf({}).find("flight.txt: 0 poses"), std::string::npos);
  EXPECT_NE(ErrorOf(Sampled(still, 10.0, 0.2)).find("expected 0.5 s"), std::string::npos);
  vo::Trajectory turning = Sampled(still, 1.0, 3.0);
  turning[2].world_from_body.rotation = Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitX());
  EXPECT_NE(ErrorOf(turning).find("turns by more than 120 degrees"), std::string::npos);
  EXPECT_EQ(ErrorOf(Sampled(still, 2.0, 0.5)), "");  // Two poses.
}

TEST(TakeOffTest, IsTheEndOfTheRestBeforeTheFlight) {
  // Shaken for 3 s, at rest, moved a little, at rest again until 12 s, then away.
  const SimulationPath path = [](double time) {
    const double shake = time < 3.0 ? 0.3 * std::sin(6.0 * time) : 0.0;
    const double shift = time > 6.0 ? 0.5 * std::min(time - 6.0, 1.0) : 0.0;
    const double flight = std::max(0.0, time - 12.0);
    return vo::Rigid3{Eigen::Quaterniond::Identity(), Eigen::Vector3d(shake, shift, flight)};
  };
  EXPECT_NEAR(TakeOffSeconds(Sampled(path, 50.0, 20.0), "flight.txt"), 12.0, 0.05);
  EXPECT_THROW(TakeOffSeconds(Sampled(path, 50.0, 11.0), "flight.txt"), Error);
}

struct Flight {
  const char* file;
  double earliest_s, latest_s;  ///< Of the take-off, seen in plots of the height.
};

class EurocFlightTest : public ::testing::TestWithParam<Flight> {};

TEST_P(EurocFlightTest, IsFollowedFromItsTakeOff) {
  const std::filesystem::path file =
      std::filesystem::path(GLUEVO_SHARED_DIR) / "data/trajectories/groundtruth" / GetParam().file;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
  const vo::Trajectory trajectory = vo::ReadTrajectory(file);
  const double take_off = TakeOffSeconds(trajectory, file.string());
  EXPECT_GT(take_off, GetParam().earliest_s);
  EXPECT_LT(take_off, GetParam().latest_s);
  const TrajectorySpline spline(trajectory, file.string());
  double squares = 0.0;
  double turn_squares = 0.0;
  for (const vo::StampedPose& pose : trajectory) {
    const double time = static_cast<double>(pose.timestamp_ns - trajectory[0].timestamp_ns) * 1e-9;
    const vo::Rigid3 at = spline.At(time);
    squares += (at.translation - pose.world_from_body.translation).squaredNorm();
    turn_squares += std::pow(at.rotation.angularDistance(pose.world_from_body.rotation), 2);
  }
  const auto count = static_cast<double>(trajectory.size());
  EXPECT_LT(std::sqrt(squares / count), 0.005);
  EXPECT_LT(std::sqrt(turn_squares / count), 0.01);
}

INSTANTIATE_TEST_SUITE_P(All, EurocFlightTest,
                         ::testing::Values(Flight{"MH_01_easy.txt", 40.0, 45.0},
                                           Flight{"MH_02_easy.txt", 34.0, 39.0},
                                           Flight{"MH_03_medium.txt", 14.0, 18.0},
                                           Flight{"V1_01_easy.txt", 2.0, 6.0}));

}  // namespace
}  // namespace gluevo::simulation
