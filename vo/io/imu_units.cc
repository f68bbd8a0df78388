#include "imu_units.h"

#include <algorithm>
#include <cmath>

#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/median.h"
#include "imu_columns.h"

namespace gluevo::vo {
namespace {

std::vector<double> LengthsOf(const std::vector<ImuSample>& samples,
                              Eigen::Vector3d ImuSample::*sensor) {
  std::vector<double> lengths;
  lengths.reserve(samples.size());
  for (const ImuSample& sample : samples) {
    lengths.push_back((sample.*sensor).norm());
  }
  return lengths;
}

void Scale(ImuData& data, Eigen::Vector3d ImuSample::*sensor, double factor) {
  for (ImuSample& sample : data.samples) {
    sample.*sensor *= factor;
  }
}

bool IsNear(double value, double expected) {
  constexpr double kShare = 0.2;
  return std::abs(value - expected) <= kShare * expected;
}

}  // namespace

void FitUnitOfForces(ImuData& data) {
  if (data.samples.empty()) {
    return;
  }
  const double median = Median(LengthsOf(data.samples, &ImuSample::specific_force));
  constexpr double kMilli = 1e-3;
  if (IsNear(median, 1.0)) {
    Scale(data, &ImuSample::specific_force, kStandardGravity);
    data.warnings.emplace_back(
        "accelerations are multiples of g (1 at rest), expected m/s^2: converted");
    return;
  }
  if (IsNear(kMilli * median, 1.0)) {
    Scale(data, &ImuSample::specific_force, kMilli * kStandardGravity);
    data.warnings.emplace_back(
        "accelerations are thousandths of g (1000 at rest), expected m/s^2: converted");
    return;
  }
  if (IsNear(median, kStandardGravity)) {
    return;
  }
  const std::string is = "the accelerations are " + std::to_string(median) +
                         " m/s^2 in the median, expected about 9.8, that of gravity";
  // No body falls for half of the time.
  if (median < 0.5 * kStandardGravity) {
    data.refused =
        data.path.string() + ": " + is + ": was gravity taken away, or is the unit another?";
    return;
  }
  data.warnings.push_back(is);
}

void FitUnitOfRates(ImuData& data) {
  constexpr double kFastest = 2000.0 * kDegree;
  constexpr std::size_t kHundredth = 100;
  const std::vector<double> lengths = LengthsOf(data.samples, &ImuSample::angular_velocity);
  const auto beyond = std::count_if(lengths.begin(), lengths.end(),
                                    [](double length) { return length > kFastest; });
  if (static_cast<std::size_t>(beyond) * kHundredth <= lengths.size()) {
    return;
  }
  Scale(data, &ImuSample::angular_velocity, kDegree);
  data.warnings.emplace_back(
      "turning rates are degrees a second (no sensor measures as many radians), expected rad/s: "
      "converted");
}

}  // namespace gluevo::vo
