#include "gluevo/vo/inertial/inertial_residual.h"

#include <gtest/gtest.h>

#include "inertial_flight.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kEndNs = 400'000'000;

struct Case {
  InertialState first;
  InertialState second;
  Preintegration measured;
  Eigen::Vector3d gravity;
};

// States that are off by far more than noise would have them, biases apart from those of the
// integration: no derivative is near a special value.
Case MakeCase() {
  const InertialFlight flight(1, {}, /*is_ideal=*/false, 11);
  InertialVector off;
  off << 0.3, -0.2, 0.1, 0.4, -0.3, 0.2, 0.5, 0.1, -0.4, 0.004, -0.003, 0.005, 0.05, 0.04, -0.03;
  return {Plus(flight.StateAt(0), off), Plus(flight.StateAt(kEndNs), InertialVector(-0.5 * off)),
          Preintegrate(flight.samples, 0, kEndNs, {}, {}), flight.gravity};
}

InertialVector Value(const Case& one) {
  return ComputeInertialResidual(one.first, one.second, one.measured, one.gravity).value;
}

TEST(InertialResidualTest, DerivativesAreTheNumericOnes) {
  const Case one = MakeCase();
  const InertialResidual residual =
      ComputeInertialResidual(one.first, one.second, one.measured, one.gravity);
  constexpr double kStep = 1e-5;
  const auto expect_same = [](const InertialVector& analytic, const InertialVector& numeric,
                              int i) {
    EXPECT_LT((analytic - numeric).norm(), 1e-6 * std::max(1.0, analytic.norm()))
        << "column " << i << ": " << analytic.transpose() << " is not " << numeric.transpose();
  };
  for (int i = 0; i < kInertialTangentSize; ++i) {
    const InertialVector delta = kStep * InertialVector::Unit(i);
    Case plus = one;
    Case minus = one;
    plus.first = Plus(one.first, delta);
    minus.first = Plus(one.first, InertialVector(-delta));
    expect_same(residual.by_first.col(i), (Value(plus) - Value(minus)) / (2.0 * kStep), i);
    plus = minus = one;
    plus.second = Plus(one.second, delta);
    minus.second = Plus(one.second, InertialVector(-delta));
    expect_same(residual.by_second.col(i), (Value(plus) - Value(minus)) / (2.0 * kStep), i);
  }
  for (int i = 0; i < 3; ++i) {
    Case plus = one;
    Case minus = one;
    plus.gravity[i] += kStep;
    minus.gravity[i] -= kStep;
    expect_same(residual.by_gravity.col(i), (Value(plus) - Value(minus)) / (2.0 * kStep), i);
  }
}

TEST(InertialResidualTest, DerivativeByTheTimeOffsetIsTheNumericOne) {
  const Case one = MakeCase();
  const auto at = [&](double shift_s) {
    return ComputeInertialResidual(one.first, one.second, one.measured, one.gravity, shift_s);
  };
  constexpr double kStep = 1e-6;
  for (const double shift_s : {0.0, 0.02}) {
    const InertialVector numeric =
        (at(shift_s + kStep).value - at(shift_s - kStep).value) / (2.0 * kStep);
    const InertialVector analytic = at(shift_s).by_shift;
    ASSERT_GT(analytic.segment<3>(inertial_block::kRotation).norm(), 0.05);
    EXPECT_LT((analytic - numeric).norm(), 1e-6 * analytic.norm())
        << analytic.transpose() << " is not " << numeric.transpose();
  }
}

TEST(InertialResidualTest, IsZeroWhereThePredictionLeads) {
  const Case one = MakeCase();
  const InertialState second = Predict(one.first, one.measured, one.gravity);
  const InertialVector value =
      ComputeInertialResidual(one.first, second, one.measured, one.gravity).value;
  EXPECT_LT(value.norm(), 1e-12);
}

// Where in the world and in which direction one looks along the horizon tells an inertial unit
// nothing.
TEST(InertialResidualTest, PlaceAndYawAreNotObserved) {
  const Case one = MakeCase();
  const Eigen::Quaterniond yaw(Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitZ()));
  const Rigid3 moved = {yaw, {3.0, -2.0, 5.0}};
  Case other = one;
  for (InertialState* state : {&other.first, &other.second}) {
    state->world_from_body = moved * state->world_from_body;
    state->velocity_in_world = yaw * state->velocity_in_world;
  }
  EXPECT_LT((Value(other) - Value(one)).norm(), 1e-12);
  // Another tilt contradicts gravity.
  const Rigid3 tilted = {Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX())),
                         Eigen::Vector3d::Zero()};
  for (InertialState* state : {&other.first, &other.second}) {
    state->world_from_body = tilted * state->world_from_body;
    state->velocity_in_world = tilted.rotation * state->velocity_in_world;
  }
  EXPECT_GT((Value(other) - Value(one)).norm(), 0.01);
}

}  // namespace
}  // namespace gluevo::vo
