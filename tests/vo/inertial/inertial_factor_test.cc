#include "gluevo/vo/inertial/inertial_factor.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "gluevo/vo/inertial/gravity.h"
#include "inertial_flight.h"
#include "message_of.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kEndNs = 400'000'000;

struct Case {
  InertialState first;
  InertialState second;
  InertialFactor factor;
  Eigen::Vector3d gravity;
};

Case MakeCase() {
  const InertialFlight flight(1, {}, /*is_ideal=*/false, 31);
  InertialVector off;
  off << 0.03, -0.02, 0.01, 0.04, -0.03, 0.02, 0.05, 0.01, -0.04, 0.004, -0.003, 0.005, 0.05, 0.04,
      -0.03;
  return {Plus(flight.StateAt(0), off), Plus(flight.StateAt(kEndNs), InertialVector(-0.5 * off)),
          MakeInertialFactor(Preintegrate(flight.samples, 0, kEndNs, {}, {})),
          Eigen::Vector3d(0.3, -0.2, -9.8)};
}

WhitenedInertialResidual Of(const Case& one) {
  return Whitened(one.factor, one.first, one.second, one.gravity);
}

TEST(InertialFactorTest, WhitensByTheCovariance) {
  const Case one = MakeCase();
  const InertialMatrix& covariance = one.factor.measured.covariance;
  EXPECT_LT((one.factor.whitening * covariance * one.factor.whitening.transpose() -
             InertialMatrix::Identity())
                .norm(),
            1e-6);
  const InertialVector residual =
      ComputeInertialResidual(one.first, one.second, one.factor.measured, one.gravity).value;
  const double squares = residual.dot(covariance.ldlt().solve(residual));
  EXPECT_NEAR(2.0 * Of(one).Cost(), squares, 1e-6 * squares);
}

TEST(InertialFactorTest, DerivativesAreTheNumericOnes) {
  const Case one = MakeCase();
  const WhitenedInertialResidual residual = Of(one);
  constexpr double kStep = 1e-6;
  const auto expect_same = [](const InertialVector& analytic, const Case& plus, const Case& minus,
                              int i) {
    const InertialVector numeric = (Of(plus).value - Of(minus).value) / (2.0 * kStep);
    EXPECT_LT((analytic - numeric).norm(), 1e-6 * std::max(1.0, analytic.norm())) << i;
  };
  for (int i = 0; i < kInertialTangentSize; ++i) {
    const InertialVector delta = kStep * InertialVector::Unit(i);
    Case plus = one;
    Case minus = one;
    plus.first = Plus(one.first, delta);
    minus.first = Plus(one.first, InertialVector(-delta));
    expect_same(residual.by_first.col(i), plus, minus, i);
    plus = minus = one;
    plus.second = Plus(one.second, delta);
    minus.second = Plus(one.second, InertialVector(-delta));
    expect_same(residual.by_second.col(i), plus, minus, i);
  }
  for (int i = 0; i < 2; ++i) {
    Case plus = one;
    Case minus = one;
    plus.gravity = TurnedGravity(one.gravity, kStep * Eigen::Vector2d::Unit(i));
    minus.gravity = TurnedGravity(one.gravity, -kStep * Eigen::Vector2d::Unit(i));
    expect_same(residual.by_gravity.col(i), plus, minus, i);
  }
}

TEST(InertialFactorTest, NormalEquationsAreThoseOfTheRows) {
  const Case one = MakeCase();
  const WhitenedInertialResidual residual = Of(one);
  const InertialNormalEquations equations = NormalEquationsOf(residual);
  constexpr int kGravity = 2 * kInertialTangentSize;
  const InertialMatrix across = residual.by_second.transpose() * residual.by_first;
  EXPECT_LT((equations.hessian.block<kInertialTangentSize, kInertialTangentSize>(
                 kInertialTangentSize, 0) -
             across)
                .norm(),
            1e-9 * across.norm());
  EXPECT_LT(
      (equations.gradient.segment<2>(kGravity) - residual.by_gravity.transpose() * residual.value)
          .norm(),
      1e-9 * equations.gradient.norm());
}

// The directions in which no inertial unit knows anything: three of place, one of yaw about
// gravity. `first` and `second` are where they are taken.
Eigen::Matrix<double, kInertialColumns, 4> Unobservable(const InertialState& first,
                                                        const InertialState& second,
                                                        const Eigen::Vector3d& gravity) {
  using inertial_block::kPosition;
  using inertial_block::kRotation;
  using inertial_block::kVelocity;
  Eigen::Matrix<double, kInertialColumns, 4> directions =
      Eigen::Matrix<double, kInertialColumns, 4>::Zero();
  const Eigen::Vector3d axis = gravity.normalized();
  int row = 0;
  for (const InertialState* state : {&first, &second}) {
    directions.block<3, 3>(row + kPosition, 0).setIdentity();
    directions.block<3, 1>(row + kPosition, 3) = axis.cross(state->world_from_body.translation);
    directions.block<3, 1>(row + kRotation, 3) = state->world_from_body.rotation.conjugate() * axis;
    directions.block<3, 1>(row + kVelocity, 3) = axis.cross(state->velocity_in_world);
    row += kInertialTangentSize;
  }
  return directions;
}

double InformationAlong(const Eigen::MatrixXd& hessian, const Eigen::MatrixXd& directions) {
  return (directions.transpose() * hessian * directions).diagonal().maxCoeff();
}

TEST(InertialFactorTest, TellsNothingOfPlaceAndYaw) {
  const Case one = MakeCase();
  const auto equations = NormalEquationsOf(Of(one));
  EXPECT_LT(InformationAlong(equations.hessian, Unobservable(one.first, one.second, one.gravity)),
            1e-6 * equations.hessian.diagonal().maxCoeff());
}

// Three states, of which the middle one is between two factors: linearised at two places, their sum
// claims to know yaw; with the first estimates it does not.
TEST(InertialFactorTest, FirstEstimatesGainNothingAlongYaw) {
  const InertialFlight flight(1, {}, false, 33);
  const InertialState a = flight.StateAt(0);
  const InertialState b = flight.StateAt(kEndNs);
  const InertialState c = flight.StateAt(2 * kEndNs);
  const auto factor = [&](int64_t begin, int64_t end) {
    return MakeInertialFactor(Preintegrate(flight.samples, begin, end, {}, {}));
  };
  InertialVector moved;
  moved << 0.05, 0.02, -0.03, 0.02, -0.03, 0.04, 0.1, -0.1, 0.05, 0.001, 0.0, 0.0, 0.01, 0.0, 0.0;
  const InertialState b_later = Plus(b, moved);
  const Eigen::Vector3d& gravity = flight.gravity;
  const WhitenedInertialResidual before = Whitened(factor(0, kEndNs), a, b, gravity);
  const InertialFactor after = factor(kEndNs, 2 * kEndNs);
  const auto information = [&](const WhitenedInertialResidual& second) {
    constexpr int kStates = 3 * kInertialTangentSize;
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2 * kInertialTangentSize, kStates);
    rows.block<kInertialTangentSize, kInertialTangentSize>(0, 0) = before.by_first;
    rows.block<kInertialTangentSize, kInertialTangentSize>(0, kInertialTangentSize) =
        before.by_second;
    rows.block<kInertialTangentSize, kInertialTangentSize>(kInertialTangentSize,
                                                           kInertialTangentSize) = second.by_first;
    rows.bottomRightCorner<kInertialTangentSize, kInertialTangentSize>() = second.by_second;
    const Eigen::MatrixXd hessian = rows.transpose() * rows;
    // The least information about any direction: four directions have none at all.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(hessian);
    const Eigen::VectorXd values = eigen.eigenvalues() / eigen.eigenvalues().maxCoeff();
    return std::pair(values[3], values[4]);
  };
  const auto [fourth_at_first, fifth_at_first] =
      information(WhitenedAt(after, b_later, c, gravity, b, c, gravity));
  const auto [fourth_at_both, fifth_at_both] = information(Whitened(after, b_later, c, gravity));
  EXPECT_LT(fourth_at_first, 1e-14);
  EXPECT_GT(fourth_at_both, 100.0 * fourth_at_first);
  // The value is that of the present states.
  EXPECT_EQ(WhitenedAt(after, b_later, c, gravity, b, c, gravity).value,
            Whitened(after, b_later, c, gravity).value);
}

TEST(InertialFactorTest, SaysWhenABiasIsFar) {
  Preintegration measured;
  measured.bias.gyroscope.x() = 0.02;
  measured.bias.accelerometer.y() = 0.1;
  const auto is_far = [&](double gyroscope, double accelerometer) {
    ImuBias bias = measured.bias;
    bias.gyroscope.x() += gyroscope;
    bias.accelerometer.z() += accelerometer;
    return IsBiasFar(measured, bias);
  };
  EXPECT_FALSE(is_far(0.0, 0.0));
  EXPECT_FALSE(is_far(0.009, -0.09));
  EXPECT_TRUE(is_far(-0.011, 0.0));
  EXPECT_TRUE(is_far(0.0, 0.11));
}

TEST(InertialFactorTest, RefusesWhatIsNoMeasurement) {
  EXPECT_NE(MessageOf([] { MakeInertialFactor(Preintegration()); }).find("positive definite"),
            std::string::npos);
}

}  // namespace
}  // namespace gluevo::vo
