#include "gluevo/vo/geometry/pose_uncertainty.h"

#include <gtest/gtest.h>

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

Rigid3 Moved(const Rigid3& pose, const Vector6& error) {
  return pose * Rigid3{ExpSo3(error.tail<3>()), error.head<3>()};
}

const Rigid3 kFirst{ExpSo3({0.3, -0.8, 1.1}), {2.0, -1.0, 0.5}};
const Rigid3 kSecond{ExpSo3({-0.5, 0.2, 0.4}), {0.3, 1.4, -0.7}};

TEST(PoseUncertainty, AnErrorIsTheMotionFromTheEstimateToTheTruth) {
  Vector6 error;
  error << 0.01, -0.02, 0.03, 0.02, 0.01, -0.015;
  EXPECT_LT((ErrorOfPose(kFirst, Moved(kFirst, error)) - error).norm(), 1e-12);
}

TEST(PoseUncertainty, ErrorsGoThroughAMotionAsTheirDerivativesSay) {
  constexpr double kStep = 1e-6;
  const Eigen::Matrix<double, 6, 6> through = ErrorThrough(kSecond);
  for (int column = 0; column < 6; ++column) {
    const Vector6 error = kStep * Vector6::Unit(column);
    const Vector6 numeric = ErrorOfPose(kFirst * kSecond, Moved(kFirst, error) * kSecond) / kStep;
    EXPECT_LT((numeric - through.col(column)).norm(), 1e-5) << column;
  }
}

TEST(PoseUncertainty, ErrorsOfMotionsAddUp) {
  Vector6 first;
  first << 1e-4, 2e-4, 3e-4, 4e-5, 5e-5, 6e-5;
  Vector6 second;
  second << 3e-4, 1e-4, 2e-4, 2e-5, 7e-5, 1e-5;
  const PoseCovariance composed = Compose(first.asDiagonal(), kSecond, second.asDiagonal());
  const Eigen::Matrix<double, 6, 6> through = ErrorThrough(kSecond);
  EXPECT_TRUE(composed.isApprox(PoseCovariance(through * first.asDiagonal() * through.transpose()) +
                                PoseCovariance(second.asDiagonal())));
  // A metre to the side, a rotation moves the position.
  EXPECT_GT((composed.topLeftCorner<3, 3>().trace()),
            first.head<3>().sum() + second.head<3>().sum());
}

}  // namespace
}  // namespace gluevo::vo
