#include "gluevo/vo/inertial/still_factor.h"

#include <gtest/gtest.h>

#include "inertial_flight.h"

namespace gluevo::vo {
namespace {

TEST(StillFactorTest, DerivativesAreTheNumericOnes) {
  const InertialFlight flight(1, {}, /*is_ideal=*/true, 3);
  InertialVector off;
  off << 0.3, -0.2, 0.1, 0.4, -0.3, 0.2, 0.5, 0.1, -0.4, 0.004, -0.003, 0.005, 0.05, 0.04, -0.03;
  const InertialState first = Plus(flight.StateAt(0), off);
  const InertialState second = Plus(flight.StateAt(400'000'000), InertialVector(-0.5 * off));
  const StillFactor factor = {0.5, 0.2, 2.0, 3.0};
  const StillResidual residual = ComputeStillResidual(factor, first, second);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < kInertialTangentSize; ++i) {
    const auto at = [&](double of_first, double of_second) {
      return ComputeStillResidual(factor, Plus(first, of_first * InertialVector::Unit(i)),
                                  Plus(second, of_second * InertialVector::Unit(i)))
          .value;
    };
    const Eigen::Matrix<double, kStillRows, 1> by_first =
        (at(kStep, 0.0) - at(-kStep, 0.0)) / (2.0 * kStep);
    const Eigen::Matrix<double, kStillRows, 1> by_second =
        (at(0.0, kStep) - at(0.0, -kStep)) / (2.0 * kStep);
    EXPECT_LT((residual.by_first.col(i) - by_first).norm(), 1e-6 * (1.0 + by_first.norm())) << i;
    EXPECT_LT((residual.by_second.col(i) - by_second).norm(), 1e-6 * (1.0 + by_second.norm())) << i;
  }
}

TEST(StillFactorTest, OfTwoTheMotionsThatMayBeAddUp) {
  const StillFactor joined = Join({1e-4, 2e-5, 3e-3, 1.0}, {2e-4, 3e-5, 1e-3, 2.0});
  EXPECT_DOUBLE_EQ(joined.position_sigma_m, 3e-4);
  EXPECT_DOUBLE_EQ(joined.rotation_sigma_rad, 5e-5);
  EXPECT_DOUBLE_EQ(joined.velocity_sigma, 1e-3);
  EXPECT_DOUBLE_EQ(joined.weight, 2.0);
}

}  // namespace
}  // namespace gluevo::vo
