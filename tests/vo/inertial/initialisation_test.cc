// Where an inertial unit may start, where it must not, and whether it knows how well.

#include "gluevo/vo/inertial/initialisation.h"
#include "gluevo/vo/core/angle.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <filesystem>

#include "gluevo/vo/inertial/gravity.h"
#include "gluevo/vo/io/imu_data.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "gluevo/vo/simulation/simulation.h"
#include "message_of.h"
#include "simulated_motion.h"

namespace gluevo::vo {
namespace {

constexpr double kStepS = 0.1;
constexpr int kFrames = 51;  // Five seconds.

InitialisationOptions Options() {
  InitialisationOptions options;
  options.gravity = simulation::kSimulationGravity;
  return options;
}

/// Frames that are as wrong as the options say.
Trajectory NoisyFrames(const SimulatedMotion& motion, double start_s, unsigned seed,
                       int count = kFrames) {
  const InitialisationOptions options = Options();
  return motion.Frames(start_s, count, kStepS, options.vision_position_sigma,
                       options.vision_rotation_sigma, seed);
}

InertialStart Start(const SimulatedMotion& motion, const Trajectory& frames) {
  return StartInMotion(frames, motion.samples, ImuNoise(), Options());
}

/// Errors of the biases and of gravity's direction, in the order of the covariance.
Eigen::Matrix<double, 8, 1> ErrorOf(const InertialStart& start, const SimulatedMotion& motion,
                                    const Trajectory& frames) {
  const ImuBias& bias = motion.Bias((frames.front().timestamp_ns + frames.back().timestamp_ns) / 2);
  const double length = start.gravity_in_world.norm();
  Eigen::Matrix<double, 8, 1> error;
  error << bias.gyroscope - start.bias.gyroscope, bias.accelerometer - start.bias.accelerometer,
      GravityTangent(start.gravity_in_world).transpose() * motion.Gravity() / (length * length);
  return error;
}

class FlightTest : public testing::TestWithParam<std::string> {};

TEST_P(FlightTest, StartsWithinFiveSeconds) {
  const SimulatedMotion motion(simulation::MakeSimulationPath(GetParam()), /*seconds=*/20, 3);
  for (const double start_s : {2.0, 7.0, 12.0}) {
    const Trajectory frames = NoisyFrames(motion, start_s, /*seed=*/5);
    const InertialStart start = Start(motion, frames);
    EXPECT_EQ(start.refused, "") << start_s;
    EXPECT_LT(AngleBetween(start.gravity_in_world, motion.Gravity()), 0.2 * kDegree) << start_s;
    EXPECT_NEAR(start.gravity_in_world.norm(), simulation::kSimulationGravity, 1e-9);
    EXPECT_LT(ErrorOf(start, motion, frames).head<3>().norm(), 5e-4) << start_s;
    EXPECT_LT(start.gravity_sigma, 0.3 * kDegree);
    ASSERT_EQ(start.velocities_in_world.size(), frames.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_LT((start.velocities_in_world[i] - motion.Velocity(frames[i].timestamp_ns)).norm(),
                0.03)
          << start_s << ' ' << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Paths, FlightTest,
                         testing::Values("hall_loop", "figure_eight", "fast_yaw"),
                         [](const auto& name) { return name.param; });

// Paths on which the body hardly turns for five seconds: it starts, or waits, and knows how well.
TEST(InitialisationTest, IsNoBetterThanItSaysWhereTheBodyHardlyTurns) {
  for (const char* const path : {"corridor", "hover"}) {
    const SimulatedMotion motion(simulation::MakeSimulationPath(path), /*seconds=*/20, 3);
    for (const double start_s : {2.0, 7.0, 12.0}) {
      const InertialStart start = Start(motion, NoisyFrames(motion, start_s, /*seed=*/5));
      EXPECT_LT(AngleBetween(start.gravity_in_world, motion.Gravity()), 3.0 * start.gravity_sigma)
          << path << start_s;
      EXPECT_EQ(start.refused.empty(), start.gravity_sigma <= Options().largest_gravity_sigma);
    }
  }
}

// Errors of many starts are as large as the covariance says, all eight together and gravity's
// direction alone.
TEST(InitialisationTest, KnowsHowWellItKnows) {
  constexpr int kRuns = 60;
  double all = 0.0;
  double tilt = 0.0;
  double rotation_rms = 0.0;
  double motion_rms = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const SimulatedMotion motion(simulation::MakeSimulationPath("figure_eight"), /*seconds=*/8,
                                 100 + run);
    const Trajectory frames = NoisyFrames(motion, 2.0, 1000 + run);
    const InertialStart start = Start(motion, frames);
    const Eigen::Matrix<double, 8, 1> error = ErrorOf(start, motion, frames);
    all += error.dot(start.covariance.llt().solve(error)) / 8.0 / kRuns;
    const Eigen::Vector2d turn = error.tail<2>();
    const Eigen::Matrix2d covariance = start.covariance.bottomRightCorner<2, 2>();
    tilt += turn.dot(covariance.llt().solve(turn)) / 2.0 / kRuns;
    rotation_rms += start.rotation_rms / kRuns;
    motion_rms += start.motion_rms / kRuns;
  }
  // Deviations of the means: sqrt(2 / (8 x 60)) = 0.065 and sqrt(2 / (2 x 60)) = 0.13; biases that
  // walk while they are taken as constant add to the first.
  EXPECT_GT(all, 0.7);
  EXPECT_LT(all, 1.6);
  EXPECT_GT(tilt, 0.5);
  EXPECT_LT(tilt, 1.6);
  EXPECT_NEAR(rotation_rms, 1.0, 0.1);
  EXPECT_NEAR(motion_rms, 1.0, 0.1);
}

TEST(InitialisationTest, WaitsWhereATiltLooksLikeABias) {
  // Straight on at constant speed.
  const SimulatedMotion straight(
      [](double t) {
        return Rigid3{Eigen::Quaterniond::Identity(), {1.5 * t, 0.2 * t, 0.0}};
      },
      /*seconds=*/8, 1);
  const InertialStart start = Start(straight, NoisyFrames(straight, 1.0, 2));
  EXPECT_NE(start.refused.find("the body has to turn"), std::string::npos) << start.refused;
  EXPECT_GT(start.gravity_sigma, kDegree);
  // It is nevertheless as far off as it says.
  EXPECT_LT(AngleBetween(start.gravity_in_world, straight.Gravity()), 3.0 * start.gravity_sigma);
  // Speeding up and slowing down without turning is no better.
  const SimulatedMotion shuttle(
      [](double t) {
        return Rigid3{Eigen::Quaterniond::Identity(), {2.0 * std::sin(t), 0.0, 0.0}};
      },
      /*seconds=*/8, 1);
  EXPECT_NE(Start(shuttle, NoisyFrames(shuttle, 1.0, 2)).refused, "");
}

// Stereo sees that it stays where it is: turning tells tilt from bias then.
TEST(InitialisationTest, StartsWhereItTurnsOnTheSpot) {
  const SimulatedMotion turning(
      [](double t) {
        return Rigid3{Eigen::Quaterniond(
                          Eigen::AngleAxisd(0.6 * t, Eigen::Vector3d::UnitZ()) *
                          Eigen::AngleAxisd(0.5 * std::sin(1.3 * t), Eigen::Vector3d::UnitX())),
                      {1.0, 2.0, 3.0}};
      },
      /*seconds=*/8, 1);
  const Trajectory frames = NoisyFrames(turning, 1.0, 2);
  const InertialStart start = Start(turning, frames);
  EXPECT_EQ(start.refused, "");
  EXPECT_LT(AngleBetween(start.gravity_in_world, turning.Gravity()), 0.2 * kDegree);
  EXPECT_LT(ErrorOf(start, turning, frames).head<3>().norm(), 5e-4);
}

TEST(InitialisationTest, WaitsForEnoughFrames) {
  const SimulatedMotion motion(simulation::MakeSimulationPath("figure_eight"), 8, 3);
  const InertialStart start = Start(motion, NoisyFrames(motion, 2.0, 5, /*count=*/6));
  EXPECT_NE(start.refused.find("expected 11 such frames or more, over 1 s"), std::string::npos)
      << start.refused;
  EXPECT_NE(Start(motion, {}).refused, "");
  EXPECT_NE(StartInMotion(NoisyFrames(motion, 2.0, 5), {}, ImuNoise(), Options()).refused, "");
}

TEST(InitialisationTest, RefusesWhatContradictsTheImages) {
  const SimulatedMotion motion(simulation::MakeSimulationPath("figure_eight"), 10, 3);
  const Trajectory frames = NoisyFrames(motion, 2.0, 5);
  const auto refused = [&](const std::vector<ImuSample>& samples) {
    return StartInMotion(frames, samples, ImuNoise(), Options()).refused;
  };
  ASSERT_EQ(refused(motion.samples), "");
  // Mounted by 10 degrees differently from what the calibration says.
  std::vector<ImuSample> samples = motion.samples;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(10.0 * kDegree, Eigen::Vector3d::UnitY()));
  for (ImuSample& sample : samples) {
    sample.angular_velocity = turn * sample.angular_velocity;
    sample.specific_force = turn * sample.specific_force;
  }
  EXPECT_NE(refused(samples).find("and the images disagree"), std::string::npos)
      << refused(samples);
  // A clock that is off by 0.1 s.
  samples = motion.samples;
  for (ImuSample& sample : samples) {
    sample.timestamp_ns += 100'000'000;
  }
  EXPECT_NE(refused(samples).find("disagree"), std::string::npos) << refused(samples);
  // A scale of the accelerometer that is no gravity.
  samples = motion.samples;
  for (ImuSample& sample : samples) {
    sample.specific_force *= 1.1;
  }
  EXPECT_NE(refused(samples), "");
}

TEST(InitialisationTest, PassesOverIntervalsWithoutSamples) {
  const SimulatedMotion motion(simulation::MakeSimulationPath("figure_eight"), 10, 3);
  std::vector<ImuSample> samples = motion.samples;
  // 0.3 s are missing, of which four intervals have a part.
  std::erase_if(samples, [](const ImuSample& sample) {
    return sample.timestamp_ns > 4'020'000'000 && sample.timestamp_ns < 4'320'000'000;
  });
  const Trajectory frames = NoisyFrames(motion, 2.0, 5);
  const InertialStart start = StartInMotion(frames, samples, ImuNoise(), Options());
  EXPECT_EQ(start.refused, "");
  EXPECT_LT(AngleBetween(start.gravity_in_world, motion.Gravity()), 0.2 * kDegree);
  EXPECT_LT((start.velocities_in_world[10] - motion.Velocity(frames[10].timestamp_ns)).norm(),
            0.03);
}

TEST(InitialisationTest, RefusesOptionsAndFramesThatCannotBe) {
  InitialisationOptions options;
  options.vision_position_sigma = 0.0;
  EXPECT_NE(MessageOf([&] { StartInMotion({}, {}, ImuNoise(), options); }).find("vision_position"),
            std::string::npos);
  EXPECT_NE(MessageOf([&] {
              StartInMotion({{5, Rigid3()}, {5, Rigid3()}}, {}, ImuNoise(), Options());
            }).find("not in order"),
            std::string::npos);
}

TEST(GravityTest, TurnsOnTheSphere) {
  for (const Eigen::Vector3d& gravity :
       {Eigen::Vector3d(0.0, 0.0, -9.81), Eigen::Vector3d(9.0, -3.0, 2.0),
        Eigen::Vector3d(0.0, 9.81, 0.0)}) {
    const GravityTangentMatrix tangent = GravityTangent(gravity);
    EXPECT_LT((tangent.transpose() * gravity).norm(), 1e-9);
    constexpr double kStep = 1e-5;
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(i);
      const Eigen::Vector3d numeric =
          (TurnedGravity(gravity, step) - TurnedGravity(gravity, -step)) / (2.0 * kStep);
      EXPECT_LT((numeric - tangent.col(i)).norm(), 1e-7 * gravity.norm());
    }
    const Eigen::Vector3d turned = TurnedGravity(gravity, {0.3, -0.4});
    EXPECT_NEAR(turned.norm(), gravity.norm(), 1e-12);
    EXPECT_NEAR(AngleBetween(turned, gravity), 0.5, 1e-9);
    EXPECT_LT((LevelFromWorld(gravity) * gravity.normalized() + Eigen::Vector3d::UnitZ()).norm(),
              1e-9);
  }
  EXPECT_LT((LevelFromWorld({0.0, 0.0, 9.81}) * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitZ())
                .norm(),
            1e-9);
}

// The recorded flight: poses of the motion capture for vision, the unit's own readings, in which
// the motors are: twenty times the data sheet's noise of the accelerometer.
TEST(RealInitialisationTest, FindsGravityOfEurocsFlight) {
  const std::filesystem::path mav0 =
      std::filesystem::path(GLUEVO_SHARED_DIR) / "data/euroc_V1_01_keyframes/mav0";
  if (!std::filesystem::exists(mav0)) {
    GTEST_SKIP() << "no EuRoC data in " << mav0;
  }
  const std::optional<ImuData> imu = FindImu(mav0.parent_path());
  ASSERT_TRUE(imu);
  const Trajectory truth = ReadTrajectory(mav0 / "state_groundtruth_estimate0/data.csv");
  InitialisationOptions options;
  options.gravity = 9.81;
  ImuNoise noise = imu->noise;
  noise.accelerometer_density *= 20.0;
  int accepted = 0;
  int windows = 0;
  // Five seconds each, ten frames a second.
  for (std::size_t begin = 160; begin + 101 < truth.size(); begin += 100, ++windows) {
    Trajectory frames;
    frames.reserve(51);
    for (std::size_t i = begin; i <= begin + 100; i += 2) {
      frames.push_back(truth[i]);
    }
    const InertialStart start = StartInMotion(frames, imu->samples, noise, options);
    const double off = AngleBetween(start.gravity_in_world, {0.0, 0.0, -9.81});
    EXPECT_LT(off, 3.0 * start.gravity_sigma) << windows;
    // The data set's own estimate.
    EXPECT_LT((start.bias.gyroscope - Eigen::Vector3d(-0.0022, 0.0215, 0.0770)).norm(), 0.004);
    accepted += start.refused.empty() && off < kDegree ? 1 : 0;
  }
  EXPECT_GE(windows, 25);
  EXPECT_GE(accepted, 20);
}

}  // namespace
}  // namespace gluevo::vo
