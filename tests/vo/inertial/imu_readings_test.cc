#include "gluevo/vo/inertial/imu_readings.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "gluevo/vo/inertial/inertial_factor.h"
#include "inertial_flight.h"
#include "message_of.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kSecondNs = 1'000'000'000;

TEST(ImuReadingsTest, MeasureAsIfAllSamplesWereGiven) {
  const InertialFlight flight(20, {}, false, 3);
  ImuReadings readings({});
  readings.Add(std::span(flight.samples).first(500));
  readings.Add(std::span(flight.samples).subspan(500));
  const auto expect_same = [&](int64_t begin, int64_t end) {
    EXPECT_TRUE(readings.Cover(begin, end));
    const Preintegration one = readings.Between(begin, end, {});
    const Preintegration other = Preintegrate(flight.samples, begin, end, {}, {});
    EXPECT_EQ(one.motion.position, other.motion.position);
    EXPECT_EQ(one.covariance, other.covariance);
    EXPECT_EQ(one.duration_s, other.duration_s);
  };
  expect_same(0, kSecondNs);
  expect_same(kSecondNs + 2'000'000, 2 * kSecondNs + 1'000'000);
  expect_same(19 * kSecondNs, 20 * kSecondNs);
  // What is behind stays the same when what is before it goes.
  readings.ForgetBefore(0);
  EXPECT_EQ(readings.samples().size(), flight.samples.size());
  readings.ForgetBefore(19 * kSecondNs + 1);
  EXPECT_LT(readings.samples().size(), 250U);
  expect_same(19 * kSecondNs + 1, 20 * kSecondNs);
}

TEST(ImuReadingsTest, AnswerInTheImagesClock) {
  const InertialFlight flight(3, {}, false, 4);
  constexpr int64_t kLateNs = 7'000'000;
  std::vector<ImuSample> late = flight.samples;
  for (ImuSample& sample : late) {
    sample.timestamp_ns += kLateNs;
  }
  ImuReadings readings({});
  readings.Add(std::span(late).first(300));
  readings.set_time_offset_s(0.003);
  readings.set_time_offset_s(0.007);
  readings.Add(std::span(late).subspan(300));
  EXPECT_EQ(readings.samples().front().timestamp_ns, 0);
  EXPECT_EQ(readings.samples().back().timestamp_ns, flight.samples.back().timestamp_ns);
  const Preintegration one = readings.Between(kSecondNs, 2 * kSecondNs, {});
  const Preintegration other = Preintegrate(flight.samples, kSecondNs, 2 * kSecondNs, {}, {});
  EXPECT_EQ(one.motion.position, other.motion.position);
  EXPECT_EQ(one.time_offset_s, 0.007);
  // Stamps are those of the unit.
  EXPECT_NE(MessageOf([&] { readings.Add(std::span(late).last(1)); }).find("3007000000 ns"),
            std::string::npos);
}

TEST(ImuReadingsTest, AGapSaysHowFarTheBiasesMayHaveWalked) {
  const InertialFlight flight(3, {}, false, 3);
  std::vector<ImuSample> samples = flight.samples;
  std::erase_if(samples, [](const ImuSample& sample) {
    return sample.timestamp_ns > kSecondNs && sample.timestamp_ns < kSecondNs + 200'000'000;
  });
  ImuReadings readings({});
  readings.Add(samples);
  EXPECT_FALSE(readings.Cover(0, 2 * kSecondNs));
  EXPECT_TRUE(readings.Cover(0, kSecondNs));
  EXPECT_FALSE(readings.Cover(2 * kSecondNs, 4 * kSecondNs));
  const ImuBias bias = {{0.1, 0.0, 0.0}, {0.0, 0.2, 0.0}};
  const Preintegration gap = readings.Between(0, 2 * kSecondNs, bias);
  EXPECT_EQ(gap.duration_s, 2.0);
  EXPECT_EQ(gap.bias.gyroscope, bias.gyroscope);
  const ImuNoise noise;
  constexpr int kGyroscope = inertial_block::kGyroscopeBias;
  constexpr int kAccelerometer = inertial_block::kAccelerometerBias;
  EXPECT_NEAR(gap.covariance(kGyroscope, kGyroscope),
              2.0 * noise.gyroscope_random_walk * noise.gyroscope_random_walk, 1e-18);
  EXPECT_NEAR(gap.covariance(kAccelerometer, kAccelerometer),
              2.0 * noise.accelerometer_random_walk * noise.accelerometer_random_walk, 1e-12);
  // Any motion agrees with it, and what follows can be joined.
  const InertialFactor factor = MakeInertialFactor(gap);
  EXPECT_LT(Whitened(factor, flight.StateAt(0), flight.StateAt(2 * kSecondNs), flight.gravity)
                .value.head<9>()
                .norm(),
            0.1);
  const Preintegration joined =
      Join(gap, readings.Between(2 * kSecondNs, 2 * kSecondNs + 500'000'000, bias));
  EXPECT_DOUBLE_EQ(joined.duration_s, 2.5);
  EXPECT_EQ(joined.covariance.ldlt().info(), Eigen::Success);
  MakeInertialFactor(joined);
}

TEST(ImuReadingsTest, RefuseWhatIsNotInOrder) {
  ImuReadings readings({});
  ImuSample sample;
  sample.timestamp_ns = 7;
  readings.Add(std::span(&sample, 1));
  EXPECT_NE(MessageOf([&] { readings.Add(std::span(&sample, 1)); }).find("at 7 ns"),
            std::string::npos);
  EXPECT_EQ(readings.samples().size(), 1U);
  EXPECT_NE(MessageOf([&] { readings.Between(5, 5, {}); }).find("does not end"), std::string::npos);
}

}  // namespace
}  // namespace gluevo::vo
