// Which frames become key frames.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "gluevo/vo/pipeline/odometry.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int kFrames = 60;

struct Outcome {
  int keyframes = 0;  // Of those after the window's first.
  double error_m = 0.0;
  double error_rad = 0.0;
};

// Points all round a rig that stands in the middle and turns by so much a frame.
Outcome TurnOnTheSpot(double radians_a_frame, double min_keyframe_overlap) {
  const StereoRig rig = testing::SimulatedRig();
  std::mt19937_64 generator(5);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 2000; ++i) {
    const double angle = testing::Uniform(generator, -3.14, 3.14);
    const double distance = testing::Uniform(generator, 3.0, 6.0);
    points.emplace_back(distance * std::cos(angle), distance * std::sin(angle),
                        testing::Uniform(generator, -2.0, 2.0));
  }
  const auto pose_at = [&](int frame) {
    return Rigid3{ExpSo3({0.0, 0.0, radians_a_frame * frame}), Eigen::Vector3d::Zero()};
  };
  std::vector<TrackedFrame> frames;
  for (int i = 0; i < kFrames; ++i) {
    frames.push_back(testing::Simulate(rig, points, pose_at(i), 100'000'000 * int64_t{i},
                                       {.noise_px = 0.3, .max_observations = 300}));
  }
  OdometryOptions options;
  options.window.min_keyframe_overlap = min_keyframe_overlap;
  Odometry odometry(rig, std::make_unique<testing::ScriptedFrontEnd>(frames), options);
  Outcome outcome;
  FrameResult newest;
  for (int i = 0; i < kFrames; ++i) {
    newest = odometry.Process({frames[i].timestamp_ns, {}});
    outcome.keyframes += i >= options.window.size && newest.is_keyframe ? 1 : 0;
  }
  const Rigid3 error =
      newest.world_from_body.Inverse() * pose_at(0).Inverse() * pose_at(kFrames - 1);
  outcome.error_m = error.translation.norm();
  outcome.error_rad = Eigen::AngleAxisd(error.rotation).angle();
  return outcome;
}

TEST(Keyframes, ARigThatStandsStillHasNoNewOnes) {
  EXPECT_EQ(TurnOnTheSpot(0.0, 0.7).keyframes, 0);
}

// Parallax tells nothing of what has come into view.
TEST(Keyframes, ARigThatTurnsOnTheSpotHasNewOnes) {
  const Outcome outcome = TurnOnTheSpot(0.03, 0.7);
  // The view is 1.5 rad wide: a third of it is new every 0.45 rad, of 1.5 rad in all.
  EXPECT_GE(outcome.keyframes, 2);
  EXPECT_LE(outcome.keyframes, 8);
  EXPECT_LT(outcome.error_m, 0.01);
  EXPECT_LT(outcome.error_rad, 0.002);
  EXPECT_LT(TurnOnTheSpot(0.03, 0.0).keyframes, outcome.keyframes);
}

}  // namespace
}  // namespace gluevo::vo
