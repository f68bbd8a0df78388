#include "two_view_refinement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/geometry/pose_uncertainty.h"
#include "vo/mapping/loop_scene.h"

namespace gluevo::vo {
namespace {

Rigid3 Motion() { return {ExpSo3({0.05, -0.1, 0.08}), {0.3, -0.2, 0.15}}; }

TEST(TwoViewRefinement, DerivativesAreThoseOfDifferences) {
  const StereoRig rig = testing::SimulatedRig();
  const Eigen::Vector3d point(0.1, -0.2, 0.4);
  const auto project = [&](const Eigen::Vector3d& at, const Rigid3& motion) {
    return internal::ProjectInto(rig.body_from_cam[1], motion, rig.body_from_cam[0], at);
  };
  const auto projection = project(point, Motion());
  ASSERT_TRUE(projection);
  // The same by way of metres.
  const Eigen::Vector3d in_cam =
      rig.body_from_cam[1].Inverse() *
      (Motion().Inverse() *
       (rig.body_from_cam[0] * (Eigen::Vector3d(point.x(), point.y(), 1.0) / point.z())));
  EXPECT_LT((projection->place - in_cam.hnormalized()).norm(), 1e-12);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
    const Eigen::Vector2d difference =
        (project(point + step, Motion())->place - project(point - step, Motion())->place) /
        (2.0 * kStep);
    EXPECT_LT((difference - projection->by_point.col(i)).norm(), 1e-8) << i;
  }
  for (int i = 0; i < 6; ++i) {
    const PoseTangent step = kStep * PoseTangent::Unit(i);
    const Eigen::Vector2d difference = (project(point, Plus(Motion(), step))->place -
                                        project(point, Plus(Motion(), -step))->place) /
                                       (2.0 * kStep);
    EXPECT_LT((difference - projection->by_motion.col(i)).norm(), 1e-8) << i;
  }
}

// What two pairs see of a room, keypoints off by `noise_px`.
std::vector<internal::TwoViewPoint> Look(double noise_px, std::mt19937& random) {
  const StereoRig rig = testing::SimulatedRig();
  const double noise = FromReferencePx(noise_px);
  std::normal_distribution<double> normal(0.0, noise > 0.0 ? noise : 1.0);
  std::uniform_real_distribution<double> side(-0.3, 0.3);
  std::uniform_real_distribution<double> depth(2.0, 8.0);
  std::vector<internal::TwoViewPoint> points;
  for (int i = 0; i < 80; ++i) {
    const double z = depth(random);
    const Eigen::Vector3d in_left(side(random) * z, side(random) * z, z);
    const Eigen::Vector3d in_a = rig.body_from_cam[0] * in_left;
    const auto see = [&](const Rigid3& a_from_body) {
      const auto in_camera = [&](std::size_t camera) {
        Eigen::Vector2d place =
            (rig.body_from_cam[camera].Inverse() * (a_from_body.Inverse() * in_a)).hnormalized();
        if (noise > 0.0) {
          place += Eigen::Vector2d(normal(random), normal(random));
        }
        return place;
      };
      StereoKeypoint keypoint{in_camera(0), true, in_camera(1), 0.0};
      keypoint.inverse_depth =
          std::max(0.02, (keypoint.left.x() - keypoint.right.x()) / rig.baseline());
      return keypoint;
    };
    points.push_back({see({}), see(Motion())});
  }
  return points;
}

Rigid3 Near(const Rigid3& motion) {
  PoseTangent off;
  off << 0.03, -0.02, 0.02, 0.01, -0.01, 0.01;
  return Plus(motion, off);
}

TEST(TwoViewRefinement, ExactViewsGiveTheExactMotion) {
  std::mt19937 random(1);
  const auto refined =
      internal::RefineMotion(testing::SimulatedRig(), Look(0.0, random), Near(Motion()), 1.0);
  ASSERT_TRUE(refined);
  EXPECT_LT(Minus(refined->candidate_from_query, Motion()).norm(), 1e-6);
}

TEST(TwoViewRefinement, ErrorsAreAsLargeAsTheCovarianceSays) {
  std::mt19937 random(2);
  constexpr int kRounds = 200;
  double sum = 0.0;
  for (int i = 0; i < kRounds; ++i) {
    // The noise is taken from the residuals, not from what it is thought to be.
    const auto refined =
        internal::RefineMotion(testing::SimulatedRig(), Look(1.0, random), Near(Motion()), 2.0);
    ASSERT_TRUE(refined);
    const Eigen::Matrix<double, 6, 1> error = ErrorOfPose(refined->candidate_from_query, Motion());
    sum += error.dot(refined->covariance.ldlt().solve(error)) / 6.0;
  }
  // The mean of 200 chi-square values of six degrees of freedom is within 0.12 in 997 of 1000.
  EXPECT_NEAR(sum / kRounds, 1.0, 0.15);
}

TEST(TwoViewRefinement, AFewWrongMatchesHardlyCount) {
  std::mt19937 random(3);
  std::vector<internal::TwoViewPoint> points = Look(0.5, random);
  for (std::size_t i = 0; i < 6; ++i) {
    points[i].in_b.left += Eigen::Vector2d(0.02, -0.01);
  }
  const auto refined = internal::RefineMotion(testing::SimulatedRig(), points, Near(Motion()), 1.0);
  ASSERT_TRUE(refined);
  EXPECT_LT((refined->candidate_from_query.translation - Motion().translation).norm(), 0.01);
}

TEST(TwoViewRefinement, PointsWithoutDepthTellNothing) {
  std::mt19937 random(4);
  std::vector<internal::TwoViewPoint> points = Look(0.5, random);
  for (internal::TwoViewPoint& point : points) {
    point.in_a.inverse_depth = 0.0;
    point.in_b.inverse_depth = 0.0;
  }
  EXPECT_FALSE(internal::RefineMotion(testing::SimulatedRig(), points, Near(Motion()), 1.0));
}

}  // namespace
}  // namespace gluevo::vo
