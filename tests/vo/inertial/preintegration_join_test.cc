#include <gtest/gtest.h>

#include "gluevo/vo/inertial/preintegration.h"
#include "inertial_flight.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kMiddleNs = 400'000'000;
constexpr int64_t kEndNs = 1'000'000'000;

double Difference(const InertialMotion& a, const InertialMotion& b) {
  return std::max({(a.position - b.position).norm(), (a.velocity - b.velocity).norm(),
                   a.rotation.angularDistance(b.rotation)});
}

// Where a sample lies at the middle, each step is the same as in the whole.
TEST(PreintegrationJoinTest, IsTheSameAsIntegratingOverBoth) {
  const InertialFlight flight(2, {}, /*is_ideal=*/false, 21);
  const ImuBias bias = {{0.01, -0.02, 0.015}, {0.05, 0.1, -0.08}};
  const Preintegration whole = Preintegrate(flight.samples, 0, kEndNs, bias, {});
  const Preintegration joined = Join(Preintegrate(flight.samples, 0, kMiddleNs, bias, {}),
                                     Preintegrate(flight.samples, kMiddleNs, kEndNs, bias, {}));
  EXPECT_NEAR(joined.duration_s, whole.duration_s, 1e-12);
  EXPECT_EQ(joined.bias.gyroscope, bias.gyroscope);
  EXPECT_LT(Difference(joined.motion, whole.motion), 1e-12);
  EXPECT_LT((joined.by_bias - whole.by_bias).norm(), 1e-10 * whole.by_bias.norm());
  EXPECT_LT((joined.covariance - whole.covariance).norm(), 1e-10 * whole.covariance.norm());
  // Each entry, by what it is measured in.
  for (int i = 0; i < kInertialTangentSize; ++i) {
    for (int j = 0; j < kInertialTangentSize; ++j) {
      EXPECT_NEAR(joined.covariance(i, j), whole.covariance(i, j),
                  1e-9 * std::sqrt(whole.covariance(i, i) * whole.covariance(j, j)))
          << i << ' ' << j;
    }
  }
}

TEST(PreintegrationJoinTest, MovesAlongTheReadingsAsTheWhole) {
  const InertialFlight flight(2, {}, /*is_ideal=*/false, 24);
  const Preintegration whole = Preintegrate(flight.samples, 0, kEndNs, {}, {});
  const Preintegration first = Preintegrate(flight.samples, 0, kMiddleNs, {}, {});
  Preintegration second = Preintegrate(flight.samples, kMiddleNs, kEndNs, {}, {});
  const Preintegration joined = Join(first, second);
  EXPECT_LT((joined.by_time_offset - whole.by_time_offset).norm(),
            1e-9 * whole.by_time_offset.norm());
  // One that was integrated with another time offset is brought to the first one's.
  constexpr double kShiftS = 5e-4;
  second.motion = second.At({}, kShiftS);
  second.time_offset_s = kShiftS;
  EXPECT_LT(Difference(Join(first, second).motion, joined.motion), 1e-12);
}

TEST(PreintegrationJoinTest, ThreeMakeOneInAnyOrder) {
  const InertialFlight flight(2, {}, false, 22);
  const auto between = [&](int64_t begin, int64_t end) {
    return Preintegrate(flight.samples, begin, end, {}, {});
  };
  const Preintegration a = between(0, 300'000'000);
  const Preintegration b = between(300'000'000, 500'000'000);
  const Preintegration c = between(500'000'000, kEndNs);
  const Preintegration left = Join(Join(a, b), c);
  const Preintegration right = Join(a, Join(b, c));
  EXPECT_LT(Difference(left.motion, right.motion), 1e-12);
  EXPECT_LT((left.by_bias - right.by_bias).norm(), 1e-10 * left.by_bias.norm());
  EXPECT_LT((left.covariance - right.covariance).norm(), 1e-10 * left.covariance.norm());
}

TEST(PreintegrationJoinTest, BringsTheSecondToTheFirstOnesBias) {
  const InertialFlight flight(2, {}, false, 23);
  const ImuBias bias = {{0.01, -0.02, 0.015}, {0.05, 0.1, -0.08}};
  const ImuBias near = {bias.gyroscope + Eigen::Vector3d(0.003, -0.002, 0.004),
                        bias.accelerometer + Eigen::Vector3d(0.03, 0.02, -0.04)};
  const Preintegration whole = Preintegrate(flight.samples, 0, kEndNs, bias, {});
  const Preintegration joined = Join(Preintegrate(flight.samples, 0, kMiddleNs, bias, {}),
                                     Preintegrate(flight.samples, kMiddleNs, kEndNs, near, {}));
  // As good as another bias is to first order; without it, 1e-2.
  EXPECT_LT(Difference(joined.motion, whole.motion), 3e-4);
}

}  // namespace
}  // namespace gluevo::vo
