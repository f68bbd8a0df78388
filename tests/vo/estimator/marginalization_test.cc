// What the prior is worth: estimates of a sliding window against those of full bundle adjustment.

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <vector>

#include "gluevo/vo/pipeline/odometry.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int kFrames = 40;
constexpr int kWindow = 11;

// Past a wall of points, 3 m away, turning a little: every point is seen for some 15 frames, so
// that the window forgets most of what the newest pose rests on.
Rigid3 PassingPose(int frame) {
  const double t = 0.1 * frame;
  return {ExpSo3({0.02 * std::sin(2.0 * t), 0.03 * std::sin(1.3 * t), 0.1 * std::sin(0.9 * t)}),
          {0.2 * std::sin(t), 2.0 * t, 0.1 * std::sin(1.7 * t)}};
}

// Error of the newest pose, the first one taken as exact; metres.
double FinalError(const SlidingWindowOptions& window, std::uint64_t seed) {
  const StereoRig rig = testing::SimulatedRig();
  std::mt19937_64 generator(seed);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 1500; ++i) {
    const double x = testing::Uniform(generator, 2.5, 6.0);
    const double y = testing::Uniform(generator, -4.0, 12.0);
    points.emplace_back(x, y, testing::Uniform(generator, -2.0, 2.0));
  }
  std::vector<TrackedFrame> frames;
  for (int i = 0; i < kFrames; ++i) {
    frames.push_back(testing::Simulate(rig, points, PassingPose(i), 100'000'000 * int64_t{i},
                                       {.noise_px = 1.0, .max_observations = 100, .seed = seed}));
  }
  OdometryOptions options;
  options.window = window;
  options.window.keyframe_parallax_px = 1e-3;  // every frame
  Odometry odometry(rig, std::make_unique<testing::ScriptedFrontEnd>(frames), options);
  Rigid3 newest;
  for (const TrackedFrame& frame : frames) {
    newest = odometry.Process({frame.timestamp_ns, {}}).world_from_body;
  }
  const Rigid3 truth = PassingPose(0).Inverse() * PassingPose(kFrames - 1);
  return (newest.translation - truth.translation).norm();
}

double RmsFinalError(const SlidingWindowOptions& window) {
  constexpr int kRuns = 12;
  double sum = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const double error = FinalError(window, 100 + run);
    sum += error * error;
  }
  return std::sqrt(sum / kRuns);
}

TEST(Marginalization, ComesCloseToFullBundleAdjustment) {
  SlidingWindowOptions options;
  options.right_turn_sigma_mrad = 0.0;
  options.size = kFrames + 1;
  const double full = RmsFinalError(options);
  options.size = kWindow;
  const double with_prior = RmsFinalError(options);
  options.marginalize = false;
  const double without_prior = RmsFinalError(options);
  std::cout << "error of the newest pose, m: full bundle adjustment " << full << ", with the prior "
            << with_prior << ", without " << without_prior << '\n';
  EXPECT_LT(with_prior, 1.2 * full);
  EXPECT_GT(without_prior, 1.2 * full);
  EXPECT_GT(without_prior, with_prior);
}

}  // namespace
}  // namespace gluevo::vo
