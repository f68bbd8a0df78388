// The right camera is not where its calibration says, or its lens is not what it says.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "gluevo/vo/pipeline/odometry.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int kFrames = 40;

// Forward through a room, as a car drives: near points come at the border.
Rigid3 ForwardPose(int frame) {
  const double t = 0.1 * frame;
  return {ExpSo3({0.02 * std::sin(2.0 * t), 0.03 * std::sin(1.3 * t), 0.1 * std::sin(0.9 * t)}),
          {2.0 * t, 0.2 * std::sin(t), 0.1 * std::sin(1.7 * t)}};
}

struct Outcome {
  StereoCalibrationEstimate calibration;
  double scale = 0.0;  // Of the path: estimate over truth.
  std::vector<FrameResult> frames;
};

// `right_is_seen_at`: where the right camera sees what one as calibrated sees at a point.
template <typename RightIsSeenAt>
Outcome Drive(double sigma_mrad, RightIsSeenAt right_is_seen_at) {
  const StereoRig rig = testing::SimulatedRig();
  std::mt19937_64 generator(3);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 3000; ++i) {
    const double along = testing::Uniform(generator, 0.0, 40.0);
    const double side = testing::Uniform(generator, 1.5, 4.0);
    const double left = i % 2 == 0 ? side : -side;
    points.emplace_back(along, left, testing::Uniform(generator, -1.5, 2.0));
  }
  std::vector<TrackedFrame> frames;
  for (int i = 0; i < kFrames; ++i) {
    frames.push_back(testing::Simulate(rig, points, ForwardPose(i), 100'000'000 * int64_t{i},
                                       {.noise_px = 0.3, .max_observations = 300}));
    for (Observation& observation : frames.back().observations) {
      observation.right = right_is_seen_at(observation.right);
    }
  }
  OdometryOptions options;
  options.window.right_turn_sigma_mrad = sigma_mrad;
  Odometry odometry(rig, std::make_unique<testing::ScriptedFrontEnd>(frames), options);
  std::vector<FrameResult> results;
  for (const TrackedFrame& frame : frames) {
    results.push_back(odometry.Process({frame.timestamp_ns, {}}));
  }
  const Rigid3 truth = ForwardPose(0).Inverse() * ForwardPose(kFrames - 1);
  const double scale = results.back().world_from_body.translation.norm() / truth.translation.norm();
  return {results.back().stereo_calibration.value_or(StereoCalibrationEstimate()), scale, results};
}

Eigen::Vector2d Turned(const Eigen::Vector3d& turn, const Eigen::Vector2d& seen) {
  return (ExpSo3(turn) * seen.homogeneous()).hnormalized();
}

TEST(StereoCalibration, ATurnedCameraIsFound) {
  const Outcome exact = Drive(0.5, [](const Eigen::Vector2d& seen) { return seen; });
  EXPECT_NEAR(exact.scale, 1.0, 1e-3);
  EXPECT_FALSE(exact.calibration.is_applied);
  for (const double mrad : {0.2, 0.5, -1.0}) {
    const Eigen::Vector3d turn = 1e-3 * mrad * Eigen::Vector3d(0.5, 1.0, -0.7);
    const Outcome found =
        Drive(0.5, [&](const Eigen::Vector2d& seen) { return Turned(turn, seen); });
    EXPECT_TRUE(found.calibration.is_turned);
    EXPECT_TRUE(found.calibration.is_applied);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(found.calibration.turn[axis], turn[axis],
                  0.2 * std::abs(turn[axis]) + 3.0 * found.calibration.turn_sigma[axis])
          << mrad << " mrad, axis " << axis;
      EXPECT_GT(found.calibration.turn_sigma[axis], 0.0);
      EXPECT_LT(found.calibration.turn_sigma[axis], 1e-4);
    }
    // The turn's standard deviation, 0.01 pixels, beside disparities of 5 and more.
    EXPECT_NEAR(found.scale, 1.0, 3e-3);
  }
}

// By few frames noise and what lenses add may ask for anything.
TEST(StereoCalibration, NothingIsSaidOrMadeUpForBeforeFramesEnoughAreSeen) {
  constexpr std::size_t kFewest = 5;
  const auto turned = [](const Eigen::Vector2d& seen) { return Turned({0, 1e-3, 0}, seen); };
  const std::vector<FrameResult> with = Drive(0.5, turned).frames;
  const std::vector<FrameResult> without = Drive(0.0, turned).frames;
  for (std::size_t i = 0; i < with.size(); ++i) {
    EXPECT_FALSE(without[i].stereo_calibration);
    ASSERT_EQ(with[i].stereo_calibration.has_value(), i + 1 >= kFewest) << i;
    if (i + 1 < kFewest) {
      EXPECT_EQ(with[i].world_from_body.translation, without[i].world_from_body.translation) << i;
    } else {
      EXPECT_TRUE((with[i].stereo_calibration->turn_sigma.array() > 0.0).all()) << i;
    }
  }
}

// What matching to subpixels errs by in one direction is none of the calibration's.
TEST(StereoCalibration, WhatMatchingErrsByIsNotMadeUpFor) {
  constexpr double kBias = 0.01 / 460.0;
  const Outcome biased = Drive(
      0.5, [](const Eigen::Vector2d& seen) { return Eigen::Vector2d(seen.x() - kBias, seen.y()); });
  EXPECT_FALSE(biased.calibration.is_applied);
  EXPECT_NEAR(biased.calibration.turn.y(), -kBias, 3.0 * biased.calibration.turn_sigma.y());
}

TEST(StereoCalibration, WithoutItThePathIsOff) {
  const Eigen::Vector3d turn(0.0, 5e-4, 0.0);
  const Outcome tight =
      Drive(1e-3, [&](const Eigen::Vector2d& seen) { return Turned(turn, seen); });
  EXPECT_GT(std::abs(tight.scale - 1.0), 5e-3);
}

// A shift of 0.3 px and, of what the lens's calibration left, 1 px * x^2 (KITTI has twice that).
TEST(StereoCalibration, WhatALensBendsIsNotTakenForATurn) {
  constexpr double kShift = 0.3 / 460.0;
  constexpr double kBend = 1.0 / 460.0;
  const Outcome found = Drive(0.5, [](const Eigen::Vector2d& seen) {
    return Eigen::Vector2d(seen.x() + kShift + kBend * seen.x() * seen.x(),
                           seen.y() + kBend * seen.x() * seen.y());
  });
  EXPECT_FALSE(found.calibration.is_turned);
  EXPECT_NEAR(found.calibration.turn.y(), kShift, 0.5 * kShift);
}

}  // namespace
}  // namespace gluevo::vo
