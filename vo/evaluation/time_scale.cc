#include "gluevo/vo/evaluation/time_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "gluevo/nn/error.h"
#include "pose_association.h"

namespace gluevo::vo {
namespace {

int64_t PowerOfTen(int exponent) {
  int64_t power = 1;
  for (int i = 0; i < exponent; ++i) {
    power *= 10;
  }
  return power;
}

bool Fits(int power_of_ten, const Trajectory& trajectory) {
  const int64_t largest =
      std::numeric_limits<int64_t>::max() / PowerOfTen(std::max(0, power_of_ten));
  return std::all_of(trajectory.begin(), trajectory.end(), [&](const StampedPose& pose) {
    return pose.timestamp_ns <= largest && pose.timestamp_ns >= -largest;
  });
}

// How far a median step is from what is usual, in powers of ten.
double Oddness(const Trajectory& trajectory) {
  constexpr double kTypicalStep = 0.05;
  return std::abs(std::log10(std::max(MedianStep(trajectory), 1e-9) / kTypicalStep));
}

}  // namespace

void ScaleTimes(int power_of_ten, Trajectory& trajectory) {
  if (!Fits(power_of_ten, trajectory)) {
    throw Error("times of a trajectory become too large: times 10 to the power of " +
                std::to_string(power_of_ten));
  }
  for (StampedPose& pose : trajectory) {
    pose.timestamp_ns = power_of_ten < 0 ? pose.timestamp_ns / PowerOfTen(-power_of_ten)
                                         : pose.timestamp_ns * PowerOfTen(power_of_ten);
  }
}

std::optional<TimeScale> FindTimeScale(const Trajectory& estimate, const Trajectory& groundtruth,
                                       const EvaluationOptions& options) {
  constexpr std::size_t kFewest = 3;
  const std::size_t half = (std::min(estimate.size(), groundtruth.size()) + 1) / 2;
  if (NearPoses(estimate, groundtruth, options).size() >= half) {
    return std::nullopt;
  }
  std::optional<TimeScale> best;
  std::size_t most = std::max(half, kFewest) - 1;
  double least_odd = 0.0;
  for (const bool of_estimate : {true, false}) {
    for (const int power : {-9, -6, -3, 3, 6, 9}) {
      Trajectory scaled = of_estimate ? estimate : groundtruth;
      if (!Fits(power, scaled)) {
        continue;
      }
      ScaleTimes(power, scaled);
      const std::size_t pairs = of_estimate ? NearPoses(scaled, groundtruth, options).size()
                                            : NearPoses(estimate, scaled, options).size();
      // All times scaled down to next to nothing are near each other, and say nothing.
      const double step = MedianStep(scaled);
      const bool told_apart = step > 2.0 * options.max_time_difference_s;
      if (told_apart && (pairs > most || (best && pairs == most && Oddness(scaled) < least_odd))) {
        best = TimeScale{of_estimate, power};
        most = pairs;
        least_odd = Oddness(scaled);
      }
    }
  }
  return best;
}

}  // namespace gluevo::vo
