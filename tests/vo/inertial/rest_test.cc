#include "gluevo/vo/inertial/rest.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <filesystem>

#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/inertial/gravity.h"
#include "gluevo/vo/io/imu_data.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "message_of.h"
#include "simulated_motion.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kSecondNs = 1'000'000'000;

InitialisationOptions Options() {
  InitialisationOptions options;
  options.gravity = simulation::kSimulationGravity;
  return options;
}

Rigid3 Tilted(double) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1.0, 0.3, -0.2).normalized())),
          {1.0, 2.0, 0.5}};
}

TEST(RestTest, StartsFromTheMeans) {
  const SimulatedMotion motion(&Tilted, /*seconds=*/3, 4);
  const auto rest = FindRest(motion.samples, 2 * kSecondNs, /*images_are_still=*/true, {});
  ASSERT_TRUE(rest);
  const Rigid3 pose = motion.vision_from_world * Tilted(0.0);
  const InertialStart start = StartAtRest(*rest, pose, Options());
  EXPECT_EQ(start.refused, "");
  EXPECT_LT((start.bias.gyroscope - motion.Bias(2 * kSecondNs).gyroscope).norm(), 1e-3);
  // Up to the accelerometer's bias, 0.05 m/s^2 an axis.
  EXPECT_LT(AngleBetween(start.gravity_in_world, motion.Gravity()), 0.8 * kDegree);
  EXPECT_NEAR(start.gravity_in_world.norm(), simulation::kSimulationGravity, 1e-9);
  EXPECT_EQ(start.velocities_in_world.size(), 1U);
  EXPECT_NEAR(start.gravity_sigma, 0.2 / simulation::kSimulationGravity, 1e-3);
}

// What is not known of the bias and of gravity makes up for each other: the covariance knows that
// the reading stays.
TEST(RestTest, KnowsThatTiltAndBiasGoTogether) {
  const SimulatedMotion motion(&Tilted, 3, 4);
  const auto rest = FindRest(motion.samples, 2 * kSecondNs, true, {});
  ASSERT_TRUE(rest);
  const Rigid3 pose = motion.vision_from_world * Tilted(0.0);
  const InertialStart start = StartAtRest(*rest, pose, Options());
  // d force = d bias - R^T d gravity.
  Eigen::Matrix<double, 3, 8> by_state = Eigen::Matrix<double, 3, 8>::Zero();
  by_state.block<3, 3>(0, 3).setIdentity();
  by_state.rightCols<2>() =
      -pose.rotation.conjugate().toRotationMatrix() * GravityTangent(start.gravity_in_world);
  const Eigen::Matrix3d of_reading = by_state * start.covariance * by_state.transpose();
  EXPECT_LT(std::sqrt(of_reading.diagonal().maxCoeff()), 0.02);
  EXPECT_GT(std::sqrt(start.covariance.diagonal().segment<3>(3).maxCoeff()), 0.19);
}

TEST(RestTest, IsNoneWhereTheImagesMove) {
  // A turntable: the gyroscope alone takes it for a bias.
  const SimulatedMotion turning(
      [](double t) {
        return Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(0.1 * t, Eigen::Vector3d::UnitZ())),
                      Eigen::Vector3d::Zero()};
      },
      3, 4);
  EXPECT_TRUE(FindRest(turning.samples, 2 * kSecondNs, /*images_are_still=*/true, {}));
  EXPECT_FALSE(FindRest(turning.samples, 2 * kSecondNs, /*images_are_still=*/false, {}));
}

TEST(RestTest, IsNoneInFlightAndWithoutSamples) {
  const SimulatedMotion flight(simulation::MakeSimulationPath("figure_eight"), 8, 4);
  for (int half = 4; half <= 16; ++half) {
    EXPECT_FALSE(FindRest(flight.samples, half * kSecondNs / 2, true, {})) << half;
  }
  const SimulatedMotion still(&Tilted, 3, 4);
  EXPECT_FALSE(FindRest(still.samples, 5 * kSecondNs, true, {}));
  EXPECT_FALSE(FindRest({}, kSecondNs, true, {}));
  std::vector<ImuSample> gap = still.samples;
  gap.erase(gap.begin() + 300, gap.begin() + 360);
  EXPECT_FALSE(FindRest(gap, 2 * kSecondNs, true, {}));
  RestOptions options;
  options.block_s = 0.4;
  EXPECT_NE(MessageOf([&] { FindRest(still.samples, kSecondNs, true, options); }).find("block_s"),
            std::string::npos);
}

TEST(RestTest, RefusesWhatIsNoGravity) {
  ImuRest rest;
  rest.specific_force = {0.0, 0.0, 1.0};
  const InertialStart start = StartAtRest(rest, Rigid3(), Options());
  EXPECT_NE(start.refused.find("expected gravity"), std::string::npos) << start.refused;
}

// Before the take-off motors run already.
TEST(RealRestTest, FindsEurocsBeforeTheTakeOff) {
  const std::filesystem::path mav0 =
      std::filesystem::path(GLUEVO_SHARED_DIR) / "data/euroc_V1_01_start/mav0";
  if (!std::filesystem::exists(mav0)) {
    GTEST_SKIP() << "no EuRoC data in " << mav0;
  }
  const std::optional<ImuData> imu = FindImu(mav0.parent_path());
  ASSERT_TRUE(imu);
  const Trajectory truth = ReadTrajectory(mav0 / "state_groundtruth_estimate0/data.csv");
  const StampedPose& pose = truth.at(truth.size() / 2);
  const auto rest = FindRest(imu->samples, pose.timestamp_ns, true, {});
  ASSERT_TRUE(rest);
  const InertialStart start = StartAtRest(*rest, pose.world_from_body, Options());
  EXPECT_EQ(start.refused, "");
  EXPECT_LT(AngleBetween(start.gravity_in_world, {0.0, 0.0, -9.81}), kDegree);
  // The data set's own estimate.
  EXPECT_LT((start.bias.gyroscope - Eigen::Vector3d(-0.0022, 0.0215, 0.0770)).norm(), 0.005);
}

}  // namespace
}  // namespace gluevo::vo
