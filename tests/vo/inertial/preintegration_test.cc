#include "gluevo/vo/inertial/preintegration.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/inertial/inertial_residual.h"
#include "inertial_flight.h"
#include "message_of.h"

namespace gluevo::vo {
namespace {

using inertial_block::kPosition;
using inertial_block::kRotation;

constexpr int64_t kHalfSecondNs = 500'000'000;

Eigen::Matrix<double, 9, 1> Difference(const InertialMotion& a, const InertialMotion& b) {
  Eigen::Matrix<double, 9, 1> difference;
  difference << a.position - b.position, LogSo3(b.rotation.conjugate() * a.rotation),
      a.velocity - b.velocity;
  return difference;
}

// Against the path itself: what integration by samples adds must be small beside the noise.
TEST(PreintegrationTest, LeadsAlongThePathWhereSensorsAreIdeal) {
  const InertialFlight flight(/*seconds=*/20, {}, /*is_ideal=*/true, /*seed=*/1);
  for (int k = 0; k < 39; ++k) {
    const int64_t begin = k * kHalfSecondNs;
    const Preintegration measured =
        Preintegrate(flight.samples, begin, begin + kHalfSecondNs, {}, {});
    EXPECT_NEAR(measured.duration_s, 0.5, 1e-12);
    const InertialState reached = Predict(flight.StateAt(begin), measured, flight.gravity);
    const InertialState truth = flight.StateAt(begin + kHalfSecondNs);
    EXPECT_LT((reached.world_from_body.translation - truth.world_from_body.translation).norm(),
              1e-4);
    EXPECT_LT((reached.velocity_in_world - truth.velocity_in_world).norm(), 2e-4);
    EXPECT_LT(reached.world_from_body.rotation.angularDistance(truth.world_from_body.rotation),
              2e-5);
  }
}

// Errors of noisy samples are as large as the covariance says: their squares, weighed by it, have
// the chi-square distribution of 15 degrees of freedom a piece.
TEST(PreintegrationTest, ErrorsAreAsLargeAsTheCovarianceSays) {
  constexpr int kIntervals = 400;
  const ImuNoise noise;
  const InertialFlight flight(/*seconds=*/kIntervals / 2 + 1, noise, /*is_ideal=*/false,
                              /*seed=*/7);
  InertialMatrix sum = InertialMatrix::Zero();
  for (int k = 0; k < kIntervals; ++k) {
    // Ends that lie between samples.
    const int64_t begin = k * kHalfSecondNs + 1'700'000;
    const InertialState first = flight.StateAt(begin);
    const Preintegration measured =
        Preintegrate(flight.samples, begin, begin + kHalfSecondNs, first.bias, noise);
    const InertialVector error =
        ComputeInertialResidual(first, flight.StateAt(begin + kHalfSecondNs), measured,
                                flight.gravity)
            .value;
    const InertialVector whitened = measured.covariance.llt().matrixL().solve(error);
    sum += whitened * whitened.transpose();
  }
  // The deviation of the mean of 15 x 400 squares is sqrt(2 / 6000) = 0.018; ends between samples
  // take up to 1 % of the noise away. Four deviations and these.
  EXPECT_NEAR(sum.trace() / kInertialTangentSize / kIntervals, 1.0, 0.09);
  // Of each of the 15: sqrt(2 / 400) = 0.07.
  for (int i = 0; i < kInertialTangentSize; ++i) {
    EXPECT_NEAR(sum(i, i) / kIntervals, 1.0, 0.3) << i;
  }
}

TEST(PreintegrationTest, DerivativesByBiasAreTheNumericOnes) {
  const InertialFlight flight(2, {}, /*is_ideal=*/false, 3);
  const ImuBias bias = {{0.01, -0.02, 0.03}, {0.1, 0.05, -0.08}};
  const Preintegration measured = Preintegrate(flight.samples, 3'000'000, kHalfSecondNs, bias, {});
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 6; ++i) {
    const auto moved = [&](double step) {
      ImuBias other = bias;
      (i < 3 ? other.gyroscope : other.accelerometer)[i % 3] += step;
      return Preintegrate(flight.samples, 3'000'000, kHalfSecondNs, other, {}).motion;
    };
    const Eigen::Matrix<double, 9, 1> numeric =
        (Difference(moved(kStep), measured.motion) - Difference(moved(-kStep), measured.motion)) /
        (2.0 * kStep);
    EXPECT_LT((numeric - measured.by_bias.col(i)).norm(), 1e-6 * measured.by_bias.norm()) << i;
  }
}

TEST(PreintegrationTest, AnotherBiasNeedsNoNewIntegrationWhileItIsNear) {
  const InertialFlight flight(2, {}, /*is_ideal=*/false, 4);
  const Preintegration measured = Preintegrate(flight.samples, 0, 1'000'000'000, {}, {});
  const ImuBias near = {{0.006, -0.006, 0.005}, {0.06, 0.05, -0.06}};
  const Eigen::Matrix<double, 9, 1> error = Difference(
      measured.At(near), Preintegrate(flight.samples, 0, 1'000'000'000, near, {}).motion);
  EXPECT_LT(error.segment<3>(kRotation).norm(), 1e-4);
  EXPECT_LT(error.segment<3>(kPosition).norm(), 1e-3);
}

// Of the same samples, between times that are a little later.
TEST(PreintegrationTest, KnowsHowItMovesAlongTheReadings) {
  const InertialFlight flight(2, {}, /*is_ideal=*/true, 7);
  const ImuBias bias = {{0.01, -0.02, 0.015}, {0.05, 0.1, -0.08}};
  constexpr int64_t kBegin = 502'000'000;
  const auto later_by = [&](int64_t step_ns) {
    return Preintegrate(flight.samples, kBegin + step_ns, kBegin + kHalfSecondNs + step_ns, bias,
                        {});
  };
  const Preintegration measured = later_by(0);
  constexpr int64_t kStepNs = 500'000;
  const Eigen::Matrix<double, 9, 1> numeric =
      Difference(later_by(kStepNs).motion, later_by(-kStepNs).motion) / (2e-9 * kStepNs);
  for (const int block : {kPosition, kRotation, inertial_block::kVelocity}) {
    EXPECT_LT((measured.by_time_offset.segment<3>(block) - numeric.segment<3>(block)).norm(),
              2e-3 * numeric.segment<3>(block).norm())
        << block;
  }
  const Eigen::Matrix<double, 9, 1> error =
      Difference(measured.At(bias, 1e-9 * kStepNs), later_by(kStepNs).motion);
  EXPECT_LT(error.segment<3>(kRotation).norm(), 1e-5);
  EXPECT_LT(error.segment<3>(kPosition).norm(), 1e-4);
  EXPECT_EQ(measured.At(bias, 0.0).position, measured.At(bias).position);
}

TEST(PreintegrationTest, SplitIntervalsMakeTheWholeOne) {
  const InertialFlight flight(2, {}, /*is_ideal=*/false, 5);
  const int64_t middle = 402'000'000;  // Between samples.
  const int64_t end = 2 * kHalfSecondNs;
  const Preintegration whole = Preintegrate(flight.samples, 0, end, {}, {});
  const Preintegration first = Preintegrate(flight.samples, 0, middle, {}, {});
  const Preintegration second = Preintegrate(flight.samples, middle, end, {}, {});
  const InertialState start = flight.StateAt(0);
  const InertialState by_two =
      Predict(Predict(start, first, flight.gravity), second, flight.gravity);
  const InertialState by_one = Predict(start, whole, flight.gravity);
  // A step that is cut is integrated a little better.
  EXPECT_LT((by_two.world_from_body.translation - by_one.world_from_body.translation).norm(), 1e-4);
  EXPECT_LT(by_two.world_from_body.rotation.angularDistance(by_one.world_from_body.rotation), 1e-5);
}

TEST(PreintegrationTest, RefusesWhatDoesNotCoverTheInterval) {
  const InertialFlight flight(1, {}, /*is_ideal=*/true, 6);
  const auto error = [&](const std::vector<ImuSample>& samples, int64_t begin, int64_t end) {
    return MessageOf([&] { Preintegrate(samples, begin, end, {}, {}); });
  };
  EXPECT_EQ(error(flight.samples, 0, kHalfSecondNs), "no error");
  EXPECT_NE(error(flight.samples, -1, kHalfSecondNs).find("do not cover"), std::string::npos);
  EXPECT_NE(error(flight.samples, 0, 3'000'000'000).find("do not cover"), std::string::npos);
  EXPECT_NE(error({}, 0, 1).find("do not cover"), std::string::npos);
  EXPECT_NE(error(flight.samples, 5, 5).find("does not end"), std::string::npos);
  std::vector<ImuSample> repeated = flight.samples;
  repeated.insert(repeated.begin(), repeated.front());
  EXPECT_NE(error(repeated, 0, kHalfSecondNs).find("order of time"), std::string::npos);
}

}  // namespace
}  // namespace gluevo::vo
