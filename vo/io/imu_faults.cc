#include "imu_faults.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gluevo/vo/core/steps.h"
#include "gluevo/vo/core/text.h"
#include "stamp_unit.h"

namespace gluevo::vo {
namespace {

constexpr double kSecondNs = 1e9;

bool IsEarlier(const ImuSample& a, const ImuSample& b) { return a.timestamp_ns < b.timestamp_ns; }

bool HasSameReadings(const ImuSample& a, const ImuSample& b) {
  return a.angular_velocity == b.angular_velocity && a.specific_force == b.specific_force;
}

/// A time as the images' readers say it.
std::string After(const ImuData& data, int64_t time_ns) {
  return TimeText(time_ns - data.samples.front().timestamp_ns) + " after the first";
}

/// 0 of less than two samples.
double MedianStepNs(const std::vector<ImuSample>& samples) {
  std::vector<int64_t> stamps;
  stamps.reserve(samples.size());
  for (const ImuSample& sample : samples) {
    stamps.push_back(sample.timestamp_ns);
  }
  return static_cast<double>(MedianStep(std::move(stamps)));
}

/// The extreme of an axis where it has that value three times in a row.
double RangeOf(const std::vector<ImuSample>& samples, Eigen::Vector3d ImuSample::*sensor,
               std::size_t& count, double smallest_range) {
  constexpr std::size_t kInARow = 3;
  double range = std::numeric_limits<double>::infinity();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    double extreme = 0.0;
    for (const ImuSample& sample : samples) {
      extreme = std::max(extreme, std::abs((sample.*sensor)[axis]));
    }
    std::size_t longest = 0;
    std::size_t run = 0;
    std::size_t at_extreme = 0;
    for (const ImuSample& sample : samples) {
      const bool is_there = std::abs((sample.*sensor)[axis]) == extreme;
      run = is_there ? run + 1 : 0;
      at_extreme += is_there ? 1 : 0;
      longest = std::max(longest, run);
    }
    if (longest >= kInARow && extreme >= smallest_range) {
      range = std::min(range, extreme);
      count += at_extreme;
    }
  }
  return range;
}

std::string Rounded(double value) { return FixedText(value, 2); }

}  // namespace

void PutInOrder(ImuData& data) {
  std::vector<ImuSample>& samples = data.samples;
  std::size_t unordered = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    unordered += IsEarlier(samples[i], samples[i - 1]) ? 1 : 0;
  }
  if (unordered > 0) {
    std::stable_sort(samples.begin(), samples.end(), &IsEarlier);
    data.warnings.push_back(Counted(unordered, "sample") + " not in order of time: sorted");
  }
  const std::size_t before = samples.size();
  std::size_t repeated = 0;
  std::vector<ImuSample> kept;
  kept.reserve(before);
  for (const ImuSample& sample : samples) {
    if (kept.empty() || kept.back().timestamp_ns != sample.timestamp_ns) {
      kept.push_back(sample);
    } else {
      repeated += HasSameReadings(kept.back(), sample) ? 0 : 1;
    }
  }
  const std::size_t dropped = before - kept.size();
  samples = std::move(kept);
  if (dropped == 0) {
    return;
  }
  constexpr std::size_t kTenth = 10;
  if (repeated * kTenth > before) {
    data.refused = data.path.string() + ": " + std::to_string(repeated) + " of " +
                   std::to_string(before) +
                   " samples have the time of another: the times have too few digits";
  }
  data.warnings.push_back(Counted(dropped, "sample") + " with the time of another left out");
}

void LeaveOutStuck(ImuData& data) {
  const std::vector<ImuSample>& samples = data.samples;
  constexpr double kLongestNs = kSecondNs;
  std::vector<ImuSample> kept;
  kept.reserve(samples.size());
  std::size_t spans = 0;
  double longest_ns = 0.0;
  for (std::size_t begin = 0; begin < samples.size();) {
    std::size_t end = begin + 1;
    while (end < samples.size() && HasSameReadings(samples[end], samples[begin])) {
      ++end;
    }
    const auto duration =
        static_cast<double>(samples[end - 1].timestamp_ns - samples[begin].timestamp_ns);
    if (duration > kLongestNs) {
      ++spans;
      longest_ns = std::max(longest_ns, duration);
    } else {
      kept.insert(kept.end(), samples.begin() + static_cast<std::ptrdiff_t>(begin),
                  samples.begin() + static_cast<std::ptrdiff_t>(end));
    }
    begin = end;
  }
  if (spans == 0) {
    return;
  }
  const std::string how_long = TimeText(std::llround(longest_ns));
  if (kept.size() < 2) {
    data.refused =
        data.path.string() + ": the sensor is stuck: its numbers are the same for " + how_long;
  }
  data.warnings.push_back("the sensor repeats its numbers for over a second, " +
                          (spans == 1 ? "once, for " + how_long
                                      : std::to_string(spans) + " times, for up to " + how_long) +
                          ": left out");
  data.samples = std::move(kept);
}

void WarnOfGaps(ImuData& data) {
  constexpr double kGapSteps = 3.0;
  const double step = MedianStepNs(data.samples);
  std::size_t gaps = 0;
  int64_t longest = 0;
  std::size_t where = 0;
  for (std::size_t i = 1; i < data.samples.size(); ++i) {
    const int64_t duration = data.samples[i].timestamp_ns - data.samples[i - 1].timestamp_ns;
    gaps += static_cast<double>(duration) >= kGapSteps * step ? 1 : 0;
    if (duration > longest) {
      longest = duration;
      where = i - 1;
    }
  }
  if (gaps > 0) {
    data.warnings.push_back(Counted(gaps, "gap") + " without samples, the longest of " +
                            TimeText(longest) + ", " +
                            After(data, data.samples[where].timestamp_ns));
  }
}

void FindRanges(ImuData& data) {
  constexpr double kSmallestForce = 18.6;  // 2 g less what scale factors are off.
  constexpr double kSmallestRate = 2.1;    // 125 degrees a second.
  std::size_t rates = 0;
  std::size_t forces = 0;
  data.largest_rate = RangeOf(data.samples, &ImuSample::angular_velocity, rates, kSmallestRate);
  data.largest_force = RangeOf(data.samples, &ImuSample::specific_force, forces, kSmallestForce);
  if (rates > 0) {
    data.warnings.push_back("the gyroscope ends at " + Rounded(data.largest_rate) + " rad/s, in " +
                            Counted(rates, "reading") + ": the body turned faster");
  }
  if (forces > 0) {
    data.warnings.push_back("the accelerometer ends at " + Rounded(data.largest_force) +
                            " m/s^2, in " + Counted(forces, "reading") +
                            ": the body was accelerated more");
  }
}

void CleanImu(ImuData& data) {
  PutInOrder(data);
  if (!data.refused.empty()) {
    return;
  }
  const double step = MedianStepNs(data.samples);
  data.rate_hz = step > 0.0 ? kSecondNs / step : 0.0;
  if (data.rate_hz < kLeastImuRateHz) {
    data.refused = data.path.string() + ": " + Rounded(data.rate_hz) +
                   " samples a second, expected at least 50: too slow to be integrated";
    return;
  }
  WarnOfGaps(data);
  FindRanges(data);
  LeaveOutStuck(data);
}

void CheckCoverage(const std::vector<int64_t>& image_times_ns, ImuData& data) {
  if (data.samples.empty() || !data.refused.empty()) {
    return;
  }
  const int64_t first = data.samples.front().timestamp_ns;
  const int64_t last = data.samples.back().timestamp_ns;
  const auto begin = std::lower_bound(image_times_ns.begin(), image_times_ns.end(), first);
  const auto end = std::upper_bound(image_times_ns.begin(), image_times_ns.end(), last);
  const auto within = std::max<std::ptrdiff_t>(0, end - begin);
  if (within == 0) {
    // Other clocks may be centuries apart.
    constexpr double kMostNs = 9e18;
    const double after = static_cast<double>(first) - static_cast<double>(image_times_ns.front());
    data.refused = data.path.string() + ": has no sample at the time of any image: it begins " +
                   TimeText(std::llround(std::min(std::abs(after), kMostNs))) +
                   (after > 0.0 ? " after" : " before") + " the images and lasts " +
                   TimeText(last - first) + ": is it of another recording, clock or unit?";
    return;
  }
  if (within < static_cast<std::ptrdiff_t>(image_times_ns.size())) {
    data.warnings.push_back("the inertial readings cover " + std::to_string(within) + " of " +
                            std::to_string(image_times_ns.size()) + " images, number " +
                            std::to_string(begin - image_times_ns.begin()) + " to " +
                            std::to_string(end - image_times_ns.begin() - 1));
  }
}

}  // namespace gluevo::vo
