#include "gluevo/vo/geometry/pnp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/geometry/manifold.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

struct Scene {
  StereoRig rig = testing::SimulatedRig();
  Rigid3 world_from_body;
  std::vector<PnpObservation> observations;
  std::vector<bool> is_inlier;
};

struct SceneOptions {
  int count = 150;
  double outlier_share = 0.0;
  double noise_px = 0.5;
  double motion_m = 1.5;
  double turn_rad = 0.4;
  bool right = true;
  bool uncertain_depth = true;
  std::uint64_t seed = 1;
};

// Points known from a stereo view at the origin, seen again from a pose metres away. With
// `uncertain_depth` their depth comes from a noisy disparity, as in real life.
Scene MakeScene(const SceneOptions& options) {
  Scene scene;
  std::mt19937_64 generator(options.seed);
  const Eigen::Vector3d turn = testing::UniformVector(generator, options.turn_rad);
  scene.world_from_body = {ExpSo3(turn), testing::UniformVector(generator, options.motion_m)};
  const Rigid3 world_from_anchor = scene.rig.body_from_cam[0];
  const double sigma = options.noise_px / 460.0;
  const auto noise = [&] {
    const double x = sigma * testing::Gaussian(generator);
    return Eigen::Vector2d(x, sigma * testing::Gaussian(generator));
  };
  while (static_cast<int>(scene.observations.size()) < options.count) {
    const double depth = testing::Uniform(generator, 3.0, 10.0);
    const double x = testing::Uniform(generator, -0.7, 0.7);
    const Eigen::Vector2d anchor(x, testing::Uniform(generator, -0.5, 0.5));
    PnpObservation observation;
    const Eigen::Vector3d point = world_from_anchor * (depth * anchor.homogeneous());
    if (!testing::Observe(scene.rig, 0, scene.world_from_body, point, observation.left)) {
      continue;
    }
    observation.has_right = options.right && testing::Observe(scene.rig, 1, scene.world_from_body,
                                                              point, observation.right);
    observation.left += noise();
    observation.right += noise();
    const double baseline = scene.rig.baseline();
    const double inverse_depth_sigma = options.uncertain_depth ? sigma / baseline : 0.0;
    observation.point = {
        world_from_anchor.translation, world_from_anchor.rotation * anchor.homogeneous(),
        std::max(1.0 / depth + inverse_depth_sigma * testing::Gaussian(generator), 0.01),
        options.uncertain_depth ? 1.5 / 460.0 / baseline : 0.0};
    const bool is_inlier = testing::Uniform(generator, 0.0, 1.0) >= options.outlier_share;
    if (!is_inlier) {
      // A stereo match of another thing: consistent between left and right.
      const double u = testing::Uniform(generator, -0.8, 0.8);
      observation.left = {u, testing::Uniform(generator, -0.5, 0.5)};
      observation.right = observation.left - Eigen::Vector2d(0.11 / 5.0, 0.0);
    }
    scene.observations.push_back(observation);
    scene.is_inlier.push_back(is_inlier);
  }
  return scene;
}

double Degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

TEST(Pnp, ExactDataGivesTheExactPose) {
  const Scene scene = MakeScene({.noise_px = 0.0, .uncertain_depth = false});
  const auto result = SolvePnp(scene.rig, scene.observations, {}, {});
  ASSERT_TRUE(result);
  EXPECT_LT((result->world_from_body.translation - scene.world_from_body.translation).norm(), 1e-9);
  EXPECT_LT(result->world_from_body.rotation.angularDistance(scene.world_from_body.rotation), 1e-9);
  EXPECT_EQ(result->inliers, static_cast<int>(scene.observations.size()));
  EXPECT_EQ(std::count(result->verdicts.begin(), result->verdicts.end(), PnpVerdict::kInlier),
            result->inliers);
}

TEST(Pnp, FindsThePoseAmongOutliersOverWideBaselines) {
  // Error bounds are 4 of the result's own standard deviations (its noise is assumed 3 times too
  // large here), and the 0.1 m and 2 degrees.
  for (const double outliers : {0.0, 0.5, 0.8, 0.87}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Scene scene = MakeScene({.count = 250, .outlier_share = outliers, .seed = seed});
      const auto result = SolvePnp(scene.rig, scene.observations, {}, {});
      ASSERT_TRUE(result) << outliers << " seed " << seed;
      const double position_error =
          (result->world_from_body.translation - scene.world_from_body.translation).norm();
      const double turn_error =
          result->world_from_body.rotation.angularDistance(scene.world_from_body.rotation);
      EXPECT_LT(position_error, std::min(0.1, 4.0 * result->position_sigma_m)) << seed;
      EXPECT_LT(turn_error, 4.0 * result->rotation_sigma_rad) << seed;
      EXPECT_LT(Degrees(turn_error), 2.0);
      int wrong = 0;
      int missed = 0;
      for (std::size_t i = 0; i < scene.is_inlier.size(); ++i) {
        wrong += !scene.is_inlier[i] && result->verdicts[i] == PnpVerdict::kInlier;
        missed += scene.is_inlier[i] && result->verdicts[i] == PnpVerdict::kOutlier;
      }
      // Gates are 99 % for three times the noise; a random point hits a gate of some 20 x 10 px
      // in an image of 736 x 460 px with probability below 0.001, and the right view makes
      // that less.
      EXPECT_LE(missed, 1) << seed;
      EXPECT_LE(wrong, 2) << seed;
    }
  }
}

TEST(Pnp, SaysHowFarObservationsAreFromThePose) {
  // Of two coordinates with 0.5 px the median length is 0.5 * 1.18; 300 of them leave it uncertain
  // by 5 %.
  for (const double assumed_px : {0.5, 1.5}) {
    const Scene scene = MakeScene({.count = 300, .uncertain_depth = false});
    const auto result = SolvePnp(scene.rig, scene.observations, {}, {.noise_px = assumed_px});
    ASSERT_TRUE(result);
    EXPECT_NEAR(result->median_error_px, 0.589, 0.1) << assumed_px;
  }
  const Scene mostly_wrong = MakeScene({.count = 300, .outlier_share = 0.7});
  const auto result = SolvePnp(mostly_wrong.rig, mostly_wrong.observations, {}, {});
  ASSERT_TRUE(result);
  EXPECT_GT(result->median_error_px, 10.0);
}

TEST(Pnp, WorksWithoutRightViews) {
  const Scene scene = MakeScene({.outlier_share = 0.5, .right = false});
  const auto result = SolvePnp(scene.rig, scene.observations, {}, {});
  ASSERT_TRUE(result);
  EXPECT_LT((result->world_from_body.translation - scene.world_from_body.translation).norm(), 0.1);
}

TEST(Pnp, TellsAWrongRightView) {
  Scene scene = MakeScene({});
  for (std::size_t i = 0; i < scene.observations.size(); i += 10) {
    scene.observations[i].right.y() += 40.0 / 460.0;
    scene.observations[i].has_right = true;
  }
  const auto result = SolvePnp(scene.rig, scene.observations, {}, {});
  ASSERT_TRUE(result);
  for (std::size_t i = 0; i < scene.observations.size(); i += 10) {
    EXPECT_EQ(result->verdicts[i], PnpVerdict::kInlierLeft) << i;
  }
}

TEST(Pnp, UncertaintyOfDepthIsWeighed) {
  // Points 3 to 10 m away with a disparity noise of 0.5 px, seen from up to 2.6 m aside. Taking
  // the depths for exact must be worse on the average than weighing them.
  double weighed = 0.0;
  double taken_for_exact = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Scene scene = MakeScene({.seed = seed});
    const auto error = [&] {
      const auto result = SolvePnp(scene.rig, scene.observations, {}, {});
      return result
                 ? (result->world_from_body.translation - scene.world_from_body.translation).norm()
                 : 1.0;
    };
    weighed += error();
    for (PnpObservation& observation : scene.observations) {
      observation.point.inverse_depth_sigma = 0.0;
    }
    taken_for_exact += error();
  }
  EXPECT_LT(weighed, 0.8 * taken_for_exact);
}

TEST(Pnp, TheSameInputGivesTheSameResult) {
  const Scene scene = MakeScene({.outlier_share = 0.8});
  const auto first = SolvePnp(scene.rig, scene.observations, {}, {});
  const auto second = SolvePnp(scene.rig, scene.observations, {}, {});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->world_from_body.translation, second->world_from_body.translation);
  EXPECT_EQ(first->world_from_body.rotation.coeffs(), second->world_from_body.rotation.coeffs());
  EXPECT_EQ(first->verdicts, second->verdicts);
}

TEST(Pnp, AWrongGuessDoesNoHarm) {
  const Scene scene = MakeScene({.outlier_share = 0.5});
  const std::vector<Rigid3> guesses = {{ExpSo3({0.0, 0.0, 3.0}), {5.0, 5.0, 5.0}}};
  const auto result = SolvePnp(scene.rig, scene.observations, guesses, {});
  ASSERT_TRUE(result);
  EXPECT_LT((result->world_from_body.translation - scene.world_from_body.translation).norm(), 0.1);
}

TEST(Pnp, NothingFromNothing) {
  EXPECT_FALSE(SolvePnp(testing::SimulatedRig(), {}, {}, {}));
  const Scene few = MakeScene({.count = 8});
  EXPECT_FALSE(SolvePnp(few.rig, few.observations, {}, {}));
  // Outliers only.
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene noise = MakeScene({.outlier_share = 1.0, .seed = seed});
    EXPECT_FALSE(SolvePnp(noise.rig, noise.observations, {}, {})) << seed;
  }
}

TEST(Pnp, RefusesDegenerateScenes) {
  const StereoRig rig = testing::SimulatedRig();
  const auto observe = [&](const std::vector<Eigen::Vector3d>& points) {
    std::vector<PnpObservation> observations;
    for (const Eigen::Vector3d& point : points) {
      PnpObservation observation;
      const Eigen::Vector3d in_anchor = rig.body_from_cam[0].Inverse() * point;
      observation.point = {rig.body_from_cam[0].translation,
                           rig.body_from_cam[0].rotation * (in_anchor / in_anchor.z()),
                           1.0 / in_anchor.z(), 0.0};
      testing::Observe(rig, 0, {}, point, observation.left);
      observations.push_back(observation);
    }
    return observations;
  };
  // On a line the turn about it is free; in one point everything but the bearing is. The body
  // looks along x.
  std::vector<Eigen::Vector3d> line, one_place, behind;
  for (int i = 0; i < 40; ++i) {
    line.emplace_back(5.0, -1.0 + 0.05 * i, 0.3);
    one_place.emplace_back(5.0, 0.2, 0.3);
    behind.emplace_back(5.0 + 0.1 * i, -1.0 + 0.05 * (i % 7), 0.1 * (i % 5));
  }
  EXPECT_FALSE(SolvePnp(rig, observe(line), {}, {}));
  EXPECT_FALSE(SolvePnp(rig, observe(one_place), {}, {}));
  // Directions mirrored through the camera: every point would have to lie behind it.
  auto mirrored = observe(behind);
  for (PnpObservation& observation : mirrored) {
    observation.point.ray *= -1.0;
  }
  const std::vector<Rigid3> guesses = {Rigid3{}};
  EXPECT_FALSE(SolvePnp(rig, mirrored, guesses, {}));
  auto nan = observe(behind);
  for (PnpObservation& observation : nan) {
    observation.left.x() = std::numeric_limits<double>::quiet_NaN();
  }
  EXPECT_FALSE(SolvePnp(rig, nan, guesses, {}));
}

TEST(Pnp, OptionsAreChecked) {
  EXPECT_NO_THROW(PnpOptions{}.Validate());
  EXPECT_THROW(PnpOptions{.noise_px = 0.0}.Validate(), Error);
  EXPECT_THROW(PnpOptions{.confidence = 1.0}.Validate(), Error);
  EXPECT_THROW(PnpOptions{.min_inliers = 3}.Validate(), Error);
  EXPECT_THROW((PnpOptions{.min_iterations = 10, .max_iterations = 5}.Validate()), Error);
}

}  // namespace
}  // namespace gluevo::vo
