#include "gluevo/vo/inertial/gyroscope_check.h"

#include <gtest/gtest.h>

#include <string>

#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/simulation/simulation.h"
#include "simulated_motion.h"

namespace gluevo::vo {
namespace {

class GyroscopeCheckTest : public testing::Test {
 protected:
  GyroscopeCheckTest()
      : motion_(&Turning, 12, 3), frames_(motion_.Frames(1.0, 100, 0.1, 0.003, 0.001, 4)) {}

  static Rigid3 Turning(double t) {
    return {Eigen::Quaterniond(
                Eigen::AngleAxisd(0.8 * std::sin(0.9 * t), Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(0.6 * std::sin(0.7 * t + 1.0), Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(0.5 * std::sin(1.3 * t), Eigen::Vector3d::UnitX())),
            {std::sin(t), 0.0, 0.0}};
  }
  GyroscopeCheck Check(const Eigen::Matrix3d& change) const {
    std::vector<ImuSample> samples = motion_.samples;
    for (ImuSample& sample : samples) {
      sample.angular_velocity = change * sample.angular_velocity;
    }
    return CheckGyroscope(frames_, samples);
  }

  SimulatedMotion motion_;
  Trajectory frames_;
};

TEST_F(GyroscopeCheckTest, FindsNothingWrongWithAGoodOne) {
  const GyroscopeCheck check = Check(Eigen::Matrix3d::Identity());
  EXPECT_EQ(check.fault, "");
  EXPECT_FALSE(check.is_degrees);
  EXPECT_GT(check.turns, 50U);
  EXPECT_NEAR(check.scale, 1.0, 0.1);
  EXPECT_LT(check.body_from_gyroscope.angularDistance(Eigen::Quaterniond::Identity()),
            5.0 * kDegree);
}

TEST_F(GyroscopeCheckTest, TellsDegrees) {
  const GyroscopeCheck check = Check(Eigen::Matrix3d::Identity() / kDegree);
  EXPECT_TRUE(check.is_degrees);
  EXPECT_EQ(check.fault, "turning rates are degrees a second, expected rad/s");
}

TEST_F(GyroscopeCheckTest, TellsAnotherMounting) {
  const Eigen::AngleAxisd turn(30.0 * kDegree, Eigen::Vector3d(1.0, 1.0, 0.0).normalized());
  const GyroscopeCheck check = Check(turn.toRotationMatrix());
  EXPECT_NE(check.fault.find("degrees differently"), std::string::npos) << check.fault;
  EXPECT_LT(check.body_from_gyroscope.angularDistance(Eigen::Quaterniond(turn).conjugate()),
            5.0 * kDegree);
}

TEST_F(GyroscopeCheckTest, TellsAnotherScaleAndAnotherRecording) {
  EXPECT_NE(Check(2.0 * Eigen::Matrix3d::Identity()).fault.find("2.0 times as far"),
            std::string::npos)
      << Check(2.0 * Eigen::Matrix3d::Identity()).fault;
  EXPECT_NE(Check(Eigen::Matrix3d::Zero()).fault.find("shows no turns"), std::string::npos);
  std::vector<ImuSample> samples = motion_.samples;
  for (ImuSample& sample : samples) {
    sample.timestamp_ns += 1'500'000'000;
  }
  EXPECT_NE(CheckGyroscope(frames_, samples).fault.find("nothing to do with"), std::string::npos)
      << CheckGyroscope(frames_, samples).unexplained;
}

TEST_F(GyroscopeCheckTest, SaysNothingOfTooLittle) {
  const Trajectory few(frames_.begin(), frames_.begin() + 8);
  EXPECT_EQ(CheckGyroscope(few, motion_.samples).fault, "");
  EXPECT_EQ(CheckGyroscope(frames_, {}).turns, 0U);
  // About one axis alone the mounting is not known.
  const SimulatedMotion spinning(
      [](double t) {
        return Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(0.8 * t, Eigen::Vector3d::UnitZ())),
                      Eigen::Vector3d::Zero()};
      },
      8, 5);
  const Trajectory turns = spinning.Frames(1.0, 50, 0.1, 0.0, 0.0, 1);
  EXPECT_EQ(CheckGyroscope(turns, spinning.samples).fault, "");
  // But for what tilts the axis.
  std::vector<ImuSample> samples = spinning.samples;
  for (ImuSample& sample : samples) {
    std::swap(sample.angular_velocity.x(), sample.angular_velocity.z());
  }
  EXPECT_NE(CheckGyroscope(turns, samples).fault.find("degrees differently"), std::string::npos);
}

}  // namespace
}  // namespace gluevo::vo
