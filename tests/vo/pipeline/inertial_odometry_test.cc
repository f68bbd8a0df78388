// Odometry with an inertial unit, along a flight whose readings are known in closed form.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/inertial/gravity.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "message_of.h"
#include "vo/inertial/inertial_flight.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kFrameNs = 100'000'000;
constexpr int kFlightSeconds = 20;
constexpr int64_t kNewTracks = 1'000'000;

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

int64_t TimeOf(int frame) { return kFrameNs * (frame + 1); }

struct Flown {
  explicit Flown(unsigned flight_seed)
      : seed(flight_seed),
        flight(kFlightSeconds, ImuNoise(), /*is_ideal=*/false, flight_seed),
        points(testing::RoomPoints(3000, 6.0, flight_seed)) {}

  Rigid3 Truth(int frame) const { return flight.StateAt(TimeOf(frame)).world_from_body; }
  /// What a front end sees; from `pose` in place of the truth where given.
  TrackedFrame Frame(int frame, int64_t first_track_id = 0,
                     const std::optional<Rigid3>& pose = std::nullopt) const {
    return testing::Simulate(testing::SimulatedRig(), points, pose.value_or(Truth(frame)),
                             TimeOf(frame), {.noise_px = 0.5, .seed = seed}, first_track_id);
  }
  std::vector<TrackedFrame> Frames(int count) const {
    std::vector<TrackedFrame> frames;
    frames.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      frames.push_back(Frame(i));
    }
    return frames;
  }
  Eigen::Vector3d GravityInFirstBody() const {
    return Truth(0).rotation.conjugate() * flight.gravity;
  }
  /// Of a motion between two frames, metres.
  double MotionError(const std::vector<FrameResult>& results, int from, int to) const {
    const auto at = [&](int frame) {
      return results[static_cast<std::size_t>(frame)].world_from_body;
    };
    return ((at(from).Inverse() * at(to)).translation -
            (Truth(from).Inverse() * Truth(to)).translation)
        .norm();
  }
  /// Mean error of a second's motion, metres.
  double MeanError(const std::vector<FrameResult>& results) const {
    constexpr int kSecond = 10;
    const int count = static_cast<int>(results.size()) - kSecond;
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
      sum += MotionError(results, i, i + kSecond);
    }
    return sum / count;
  }

  unsigned seed;
  InertialFlight flight;
  std::vector<Eigen::Vector3d> points;
};

std::vector<FrameResult> Fly(Odometry& odometry, const std::vector<TrackedFrame>& frames) {
  std::vector<FrameResult> results;
  results.reserve(frames.size());
  for (const TrackedFrame& frame : frames) {
    results.push_back(odometry.Process({frame.timestamp_ns, {}}));
  }
  return results;
}

Odometry MakeOdometry(const std::vector<TrackedFrame>& frames) {
  return {testing::SimulatedRig(), std::make_unique<testing::ScriptedFrontEnd>(frames),
          OdometryOptions()};
}

std::vector<FrameResult> RunWithImu(const Flown& flown, const std::vector<TrackedFrame>& frames) {
  Odometry odometry = MakeOdometry(frames);
  odometry.UseImu(ImuNoise());
  odometry.AddImu(flown.flight.samples);
  return Fly(odometry, frames);
}

TEST(InertialOdometryTest, StartsInMotionAndFindsGravityAndBiases) {
  double error_with = 0.0;
  double error_without = 0.0;
  for (const unsigned seed : {1U, 2U}) {
    const Flown flown(seed);
    const std::vector<TrackedFrame> frames = flown.Frames(150);
    Odometry with = MakeOdometry(frames);
    with.UseImu(ImuNoise());
    with.AddImu(flown.flight.samples);
    const std::vector<FrameResult> results = Fly(with, frames);
    ASSERT_TRUE(with.inertial()->begin());
    EXPECT_FALSE(with.inertial()->begin()->is_at_rest);
    EXPECT_LT(with.inertial()->begin()->timestamp_ns, TimeOf(60));
    EXPECT_EQ(with.inertial()->why_waiting(), "");
    // The noise is as the calibration says.
    EXPECT_LT(with.inertial()->accelerometer_noise_factor(), 2.0);
    EXPECT_LT(with.inertial()->gyroscope_noise_factor(), 2.0);
    for (const FrameResult& result : results) {
      if (result.inertial) {
        EXPECT_LT(AngleBetween(result.inertial->gravity_in_world, flown.GravityInFirstBody()),
                  1.0 * kDegree);
      }
    }
    ASSERT_TRUE(results.back().inertial);
    const InertialEstimate& last = *results.back().inertial;
    EXPECT_LT(AngleBetween(last.gravity_in_world, flown.GravityInFirstBody()), 0.2 * kDegree);
    const InertialState truth = flown.flight.StateAt(TimeOf(149));
    EXPECT_LT((last.bias.gyroscope - truth.bias.gyroscope).norm(), 5e-4);
    EXPECT_LT((last.bias.accelerometer - truth.bias.accelerometer).norm(), 0.05);
    EXPECT_LT(
        (last.velocity_in_world - flown.Truth(0).rotation.conjugate() * truth.velocity_in_world)
            .norm(),
        0.05);
    EXPECT_LT(last.gravity_sigma, 0.3 * kDegree);
    Odometry without = MakeOdometry(frames);
    error_with += flown.MeanError(results);
    error_without += flown.MeanError(Fly(without, frames));
  }
  // And it does not harm.
  EXPECT_LT(error_with, 1.05 * error_without);
}

TEST(InertialOdometryTest, StartsAtRest) {
  const ImuBias bias = {{0.01, -0.02, 0.03}, {0.0, 0.0, 0.0}};
  const Eigen::Quaterniond tilt = ExpSo3({0.3, -0.2, 0.5});
  const Eigen::Vector3d gravity(0.0, 0.0, -9.80665);
  std::mt19937_64 generator(1);
  std::vector<ImuSample> samples;
  for (int64_t i = 0; i <= 400; ++i) {
    samples.push_back({i * 5'000'000, bias.gyroscope + testing::UniformVector(generator, 0.005),
                       tilt.conjugate() * -gravity + testing::UniformVector(generator, 0.05)});
  }
  const auto points = testing::RoomPoints(3000, 6.0, 4);
  constexpr int kFrames = 15;
  std::vector<TrackedFrame> frames;
  frames.reserve(kFrames);
  for (int i = 0; i < kFrames; ++i) {
    frames.push_back(testing::Simulate(testing::SimulatedRig(), points, {tilt, {1.0, 0.0, 0.0}},
                                       TimeOf(i), {.noise_px = 0.5}));
  }
  Odometry odometry = MakeOdometry(frames);
  odometry.UseImu(ImuNoise());
  odometry.AddImu(samples);
  const std::vector<FrameResult> results = Fly(odometry, frames);
  ASSERT_TRUE(odometry.inertial()->begin());
  EXPECT_TRUE(odometry.inertial()->begin()->is_at_rest);
  EXPECT_LT(odometry.inertial()->begin()->timestamp_ns, TimeOf(8));
  ASSERT_TRUE(results.back().inertial);
  EXPECT_LT(AngleBetween(results.back().inertial->gravity_in_world, tilt.conjugate() * gravity),
            0.5 * kDegree);
  EXPECT_LT((results.back().inertial->bias.gyroscope - bias.gyroscope).norm(), 2e-3);
  EXPECT_LT(results.back().inertial->velocity_in_world.norm(), 0.02);
  EXPECT_LT(results.back().world_from_body.translation.norm(), 0.01);
}

// Frames that show nothing, then a scene of which nothing was seen before.
TEST(InertialOdometryTest, BridgesBlackouts) {
  constexpr int kFirst = 120;
  for (const auto& [blind, bar_m] : {std::pair(5, 0.01), {10, 0.03}, {20, 0.15}, {40, 0.8}}) {
    const Flown flown(3);
    std::vector<TrackedFrame> frames = flown.Frames(kFirst);
    for (int i = kFirst; i < kFirst + blind; ++i) {
      frames.push_back({TimeOf(i), {}, {}});
    }
    for (int i = kFirst + blind; i < kFirst + blind + 15; ++i) {
      frames.push_back(flown.Frame(i, kNewTracks));
    }
    const std::vector<FrameResult> results = RunWithImu(flown, frames);
    ASSERT_TRUE(results[kFirst - 1].inertial);
    EXPECT_EQ(results.back().segment, 0) << blind;
    for (int i = kFirst; i < kFirst + blind; ++i) {
      EXPECT_TRUE(results[static_cast<std::size_t>(i)].is_predicted) << i;
      EXPECT_LT(flown.MotionError(results, kFirst - 1, i), bar_m) << blind << ' ' << i;
      // As far off as it says: chi-square of three.
      const FrameResult& result = results[static_cast<std::size_t>(i)];
      const Rigid3 truth = flown.Truth(kFirst - 1).Inverse() * flown.Truth(i);
      const Eigen::Vector3d error = result.keyframe_from_body.rotation.conjugate() *
                                    (truth.translation - result.keyframe_from_body.translation);
      EXPECT_LT(error.dot(result.motion_covariance.topLeftCorner<3, 3>().ldlt().solve(error)), 25.0)
          << blind << ' ' << i;
    }
    EXPECT_LT(flown.MotionError(results, kFirst - 1, kFirst + blind + 14), 1.2 * bar_m + 0.01)
        << blind;
    // Without it the path breaks where the scene is new.
    Odometry without = MakeOdometry(frames);
    EXPECT_EQ(Fly(without, frames).back().segment, 1) << blind;
  }
}

// What fills the view moves on by itself for a frame: the pose that it gives is not taken. Where
// image after image says so, the readings are wrong.
TEST(InertialOdometryTest, RefusesPosesThatTheReadingsContradict) {
  constexpr int kAt = 130;
  const Flown flown(5);
  const auto spoilt = [&](int count) {
    std::vector<TrackedFrame> frames = flown.Frames(150);
    for (int i = kAt; i < kAt + count; ++i) {
      Rigid3 pose = flown.Truth(i);
      pose.translation += pose.rotation * Eigen::Vector3d(0.0, 0.8, 0.0);
      frames[static_cast<std::size_t>(i)] = flown.Frame(i, 0, pose);
    }
    return frames;
  };
  const std::vector<FrameResult> once = RunWithImu(flown, spoilt(1));
  EXPECT_TRUE(once[kAt].is_refused_by_inertia);
  EXPECT_TRUE(once[kAt].is_predicted);
  EXPECT_LT(flown.MotionError(once, kAt - 1, kAt), 0.02);
  EXPECT_FALSE(once[kAt + 1].is_refused_by_inertia);
  EXPECT_EQ(once.back().segment, 0);
  Odometry without = MakeOdometry(spoilt(1));
  EXPECT_GT(flown.MotionError(Fly(without, spoilt(1)), kAt - 1, kAt), 0.5);

  const std::vector<FrameResult> often = RunWithImu(flown, spoilt(10));
  EXPECT_TRUE(often[kAt + 2].is_refused_by_inertia);
  EXPECT_FALSE(often[kAt + 3].is_refused_by_inertia);
  EXPECT_FALSE(often[kAt + 3].is_predicted);
  EXPECT_FALSE(often[kAt + 4].inertial);
}

// A tilt cannot be told from a bias where nothing turns: stereo alone goes on, to the last bit.
TEST(InertialOdometryTest, WaitsWhereItMustNotStart) {
  const auto points = testing::RoomPoints(3000, 12.0, 4);
  std::vector<TrackedFrame> frames;
  std::vector<ImuSample> samples;
  for (int64_t i = 0; i <= 1200; ++i) {
    samples.push_back({i * 5'000'000, {0.001, 0.002, -0.001}, {0.3, -0.1, 9.75}});
  }
  for (int i = 0; i < 50; ++i) {
    const Rigid3 pose = {Eigen::Quaterniond::Identity(), {-3.0 + 0.1 * i, 0.02 * i, 0.0}};
    frames.push_back(
        testing::Simulate(testing::SimulatedRig(), points, pose, TimeOf(i), {.noise_px = 0.5}));
  }
  Odometry with = MakeOdometry(frames);
  with.UseImu(ImuNoise());
  with.AddImu(samples);
  const std::vector<FrameResult> results = Fly(with, frames);
  EXPECT_FALSE(with.inertial()->begin());
  EXPECT_NE(with.inertial()->why_waiting().find("the body has to turn"), std::string::npos)
      << with.inertial()->why_waiting();
  Odometry without = MakeOdometry(frames);
  const std::vector<FrameResult> alone = Fly(without, frames);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(results[i].world_from_body.translation, alone[i].world_from_body.translation);
    EXPECT_FALSE(results[i].inertial);
  }
}

struct Clocks {
  std::vector<FrameResult> results;
  std::string fault;
};

// Readings that are stamped so much too late.
Clocks RunLate(const Flown& flown, const std::vector<TrackedFrame>& frames, double late_s,
               bool estimates) {
  std::vector<ImuSample> samples = flown.flight.samples;
  for (ImuSample& sample : samples) {
    sample.timestamp_ns += std::llround(1e9 * late_s);
  }
  OdometryOptions options;
  options.inertial.estimate_time_offset = estimates;
  Odometry odometry(testing::SimulatedRig(), std::make_unique<testing::ScriptedFrontEnd>(frames),
                    options);
  odometry.UseImu(ImuNoise());
  odometry.AddImu(samples);
  Clocks clocks{Fly(odometry, frames), ""};
  clocks.fault = odometry.inertial()->clock().Fault();
  return clocks;
}

TEST(InertialOdometryTest, FindsHowFarTheClocksAreApart) {
  const Flown flown(1);
  const std::vector<TrackedFrame> frames = flown.Frames(120);
  const double in_time = flown.MeanError(RunLate(flown, frames, 0.0, false).results);
  for (const double late_s : {-0.02, -0.005, 0.005, 0.02}) {
    const Clocks clocks = RunLate(flown, frames, late_s, /*estimates=*/true);
    ASSERT_TRUE(clocks.results.back().inertial) << late_s;
    const InertialEstimate& last = *clocks.results.back().inertial;
    ASSERT_TRUE(last.time_offset_s);
    EXPECT_NEAR(*last.time_offset_s, late_s, 5e-4);
    EXPECT_GT(last.time_offset_sigma_s, 1e-6);
    EXPECT_LT(last.time_offset_sigma_s, 5e-4);
    EXPECT_LT(flown.MeanError(clocks.results), 1.2 * in_time) << late_s;
    EXPECT_EQ(clocks.fault, "");
  }
}

TEST(InertialOdometryTest, SaysThatTheClocksAreApart) {
  const Flown flown(2);
  const std::vector<TrackedFrame> frames = flown.Frames(120);
  for (const double late_s : {-0.02, 0.02}) {
    const Clocks clocks = RunLate(flown, frames, late_s, /*estimates=*/false);
    EXPECT_NE(clocks.fault.find(late_s > 0.0 ? "too late" : "too early"), std::string::npos)
        << clocks.fault;
  }
  for (const double late_s : {-0.001, 0.0, 0.001}) {
    const Clocks clocks = RunLate(flown, frames, late_s, /*estimates=*/false);
    EXPECT_EQ(clocks.fault, "");
    EXPECT_FALSE(clocks.results.back().inertial->time_offset_s);
  }
}

TEST(InertialOdometryTest, MayBeMovedWhileItRuns) {
  const Flown flown(6);
  const std::vector<TrackedFrame> frames = flown.Frames(100);
  const std::vector<FrameResult> expected = RunWithImu(flown, frames);
  Odometry first = MakeOdometry(frames);
  first.UseImu(ImuNoise());
  first.AddImu(flown.flight.samples);
  for (int i = 0; i < 80; ++i) {
    first.Process({frames[static_cast<std::size_t>(i)].timestamp_ns, {}});
  }
  Odometry second = MakeOdometry({});
  second = std::move(first);
  FrameResult last;
  for (int i = 80; i < 100; ++i) {
    last = second.Process({frames[static_cast<std::size_t>(i)].timestamp_ns, {}});
  }
  EXPECT_TRUE(last.inertial);
  EXPECT_EQ(last.world_from_body.translation, expected.back().world_from_body.translation);
}

TEST(InertialOdometryTest, SaysWhatItCannotUse) {
  OdometryOptions options;
  options.window.solver = "ceres";
  Odometry odometry(testing::SimulatedRig(),
                    std::make_unique<testing::ScriptedFrontEnd>(std::vector<TrackedFrame>()),
                    options);
  EXPECT_NE(MessageOf([&] { odometry.UseImu(ImuNoise()); }).find("window.solver"),
            std::string::npos);
  EXPECT_NE(MessageOf([&] { odometry.AddImu({}); }).find("no inertial unit"), std::string::npos);
  EXPECT_EQ(odometry.inertial(), nullptr);
  options.inertial.max_bridge_sigma_m = 0.0;
  EXPECT_NE(MessageOf([&] { options.Validate(); }).find("max_bridge_sigma_m"), std::string::npos);
}

TEST(InertialNavigationTest, RaisesTheNoiseOfASensorThatShakes) {
  InertialNavigation navigation{ImuNoise(), InertialOptions()};
  const auto watch = [&](double gyroscope, double accelerometer) {
    for (int i = 0; i < 200; ++i) {
      navigation.Watch(gyroscope, accelerometer);
    }
  };
  watch(0.5, 1.0);
  EXPECT_EQ(navigation.gyroscope_noise_factor(), 1.0);
  EXPECT_EQ(navigation.accelerometer_noise_factor(), 1.0);
  watch(0.5, 400.0);
  EXPECT_EQ(navigation.gyroscope_noise_factor(), 1.0);
  EXPECT_GT(navigation.accelerometer_noise_factor(), 10.0);
  EXPECT_LE(navigation.accelerometer_noise_factor(), 100.0);
  EXPECT_EQ(navigation.readings().noise().accelerometer_density,
            navigation.accelerometer_noise_factor() * ImuNoise().accelerometer_density);
  EXPECT_EQ(navigation.readings().noise().gyroscope_density, ImuNoise().gyroscope_density);
}

}  // namespace
}  // namespace gluevo::vo
