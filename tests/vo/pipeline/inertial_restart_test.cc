// An inertial unit that outlives the loss of the frames' poses.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "gluevo/vo/pipeline/odometry.h"
#include "vo/inertial/inertial_flight.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int kFrames = 130;
constexpr int kLost = 100;

int64_t TimeOf(int frame) { return 100'000'000LL * (frame + 1); }

struct Flight {
  Flight() : flight(kFrames / 10 + 1, ImuNoise(), /*is_ideal=*/false, 3U) {
    const std::vector<Eigen::Vector3d> points = testing::RoomPoints(3000, 6.0, 3U);
    for (int i = 0; i < kFrames; ++i) {
      // From the loss on all tracks are new ones.
      frames.push_back(testing::Simulate(testing::SimulatedRig(), points,
                                         flight.StateAt(TimeOf(i)).world_from_body, TimeOf(i),
                                         {.noise_px = 0.5, .seed = 3U}, i < kLost ? 0 : 1'000'000));
    }
  }

  // Of a unit that turns by so much while the poses are lost and after, which it did not measure.
  std::vector<FrameResult> Fly(double wrong_rate) const {
    OdometryOptions options;
    options.inertial.max_bridge_sigma_m = 1e-4;  // The first loss breaks the path.
    options.max_predicted_s = 0.05;
    Odometry odometry(testing::SimulatedRig(), std::make_unique<testing::ScriptedFrontEnd>(frames),
                      options);
    std::vector<ImuSample> samples = flight.samples;
    for (ImuSample& sample : samples) {
      if (sample.timestamp_ns >= TimeOf(kLost - 1)) {
        sample.angular_velocity.x() += wrong_rate;
      }
    }
    odometry.UseImu(ImuNoise());
    odometry.AddImu(samples);
    std::vector<FrameResult> results;
    for (const TrackedFrame& frame : frames) {
      results.push_back(odometry.Process({frame.timestamp_ns, {}}));
    }
    return results;
  }

  InertialFlight flight;
  std::vector<TrackedFrame> frames;
};

TEST(InertialRestartTest, GravityAndBiasesAreKnownAgainAfterThreeFrames) {
  const Flight flight;
  const std::vector<FrameResult> results = flight.Fly(0.0);
  ASSERT_TRUE(results[kLost - 1].inertial);
  ASSERT_EQ(results[kLost - 1].segment, 0);
  ASSERT_EQ(results[kLost].segment, 1);
  EXPECT_FALSE(results[kLost + 1].inertial);
  constexpr int kBack = kLost + 4;
  ASSERT_TRUE(results[kBack].inertial);
  const FrameResult& back = results[kBack];
  const InertialState truth = flight.flight.StateAt(TimeOf(kBack));
  const Eigen::Vector3d seen =
      back.world_from_body.rotation.conjugate() * back.inertial->gravity_in_world;
  const Eigen::Vector3d is = truth.world_from_body.rotation.conjugate() * flight.flight.gravity;
  const double off = std::atan2(seen.cross(is).norm(), seen.dot(is));
  EXPECT_LT(off, 0.01);
  EXPECT_LT(off, 4.0 * back.inertial->gravity_sigma);
  EXPECT_LT((back.inertial->bias.gyroscope - truth.bias.gyroscope).norm(),
            4.0 * back.inertial->gyroscope_bias_sigma);
}

TEST(InertialRestartTest, AGyroscopeThatTheNewFramesContradictIsNotBelieved) {
  const std::vector<FrameResult> results = Flight().Fly(0.5);
  ASSERT_EQ(results[kLost].segment, 1);
  EXPECT_FALSE(results[kLost + 4].inertial);
}

}  // namespace
}  // namespace gluevo::vo
