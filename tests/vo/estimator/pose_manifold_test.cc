#include "pose_manifold.h"

#include <gtest/gtest.h>

#include <numbers>

#include "vo/scene.h"

namespace gluevo::vo {
namespace {

Rigid3 SomePose(std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  const Eigen::Vector3d rotation = testing::UniformVector(generator, 1.5);
  return {ExpSo3(rotation), testing::UniformVector(generator, 10.0)};
}

TEST(PoseManifold, RotationVectorsGoThereAndBack) {
  // Around the angles where the formulas switch or the logarithm turns over.
  for (const double angle : {0.0, 1e-12, 1e-9, 1e-5, 1e-4, 1.0, 3.0, std::numbers::pi - 1e-6}) {
    const Eigen::Vector3d vector = angle * Eigen::Vector3d(1.0, -2.0, 2.0) / 3.0;
    EXPECT_LT((LogSo3(ExpSo3(vector)) - vector).norm(), 1e-9) << angle;
    Eigen::Quaterniond negative = ExpSo3(vector);
    negative.coeffs() *= -1.0;
    EXPECT_LT((LogSo3(negative) - vector).norm(), 1e-9) << angle;
  }
}

TEST(PoseManifold, QuarterTurnAboutZ) {
  // exp([0, 0, pi/2]) takes x to y.
  const Eigen::Quaterniond quarter = ExpSo3({0.0, 0.0, std::numbers::pi / 2.0});
  EXPECT_LT((quarter * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-15);
}

TEST(PoseManifold, RotatesInTheBodyFrame) {
  // q <- q * exp(d): a body that looks along world y and turns about its own x axis turns about
  // world y.
  const Rigid3 pose{ExpSo3({0.0, 0.0, std::numbers::pi / 2.0}), {1.0, 2.0, 3.0}};
  PoseTangent delta;
  delta << 0.5, 0.0, 0.0, 0.1, 0.0, 0.0;
  const Rigid3 moved = Plus(pose, delta);
  EXPECT_LT((moved.translation - Eigen::Vector3d(1.5, 2.0, 3.0)).norm(), 1e-15);
  const Eigen::Quaterniond expected = ExpSo3({0.0, 0.1, 0.0}) * pose.rotation;
  EXPECT_LT(moved.rotation.angularDistance(expected), 1e-14);
}

TEST(PoseManifold, MinusUndoesPlus) {
  std::mt19937_64 generator(5);
  for (int i = 0; i < 20; ++i) {
    const Rigid3 pose = SomePose(i);
    PoseTangent delta;
    delta << testing::UniformVector(generator, 1.0), testing::UniformVector(generator, 1.0);
    EXPECT_LT((Minus(Plus(pose, delta), pose) - delta).norm(), 1e-13);
  }
}

TEST(PoseManifold, JacobiansMatchCentralDifferences) {
  const PoseManifold manifold;
  const PoseParameters x = ToParameters(SomePose(3));
  Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> minus;
  ASSERT_TRUE(manifold.PlusJacobian(x.data(), plus.data()));
  ASSERT_TRUE(manifold.MinusJacobian(x.data(), minus.data()));
  // Truncation h^2 and rounding eps / h are both below 1e-9 at this step.
  constexpr double kStep = 1e-5;
  for (int column = 0; column < 6; ++column) {
    PoseTangent delta = PoseTangent::Zero();
    PoseParameters forward, backward;
    delta[column] = kStep;
    manifold.Plus(x.data(), delta.data(), forward.data());
    delta[column] = -kStep;
    manifold.Plus(x.data(), delta.data(), backward.data());
    for (int row = 0; row < 7; ++row) {
      EXPECT_NEAR(plus(row, column), (forward[row] - backward[row]) / (2.0 * kStep), 1e-9);
    }
  }
  // Along the sphere Minus's Jacobian inverts Plus's.
  EXPECT_LT((minus * plus - Eigen::Matrix<double, 6, 6>::Identity()).norm(), 1e-14);
}

}  // namespace
}  // namespace gluevo::vo
