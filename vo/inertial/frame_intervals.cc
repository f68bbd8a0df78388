#include "frame_intervals.h"

#include <algorithm>
#include <cmath>

namespace gluevo::vo {
namespace {

constexpr int64_t kLongestStepNs = 100'000'000;

}  // namespace

bool IsCovered(const std::vector<ImuSample>& samples, int64_t begin_ns, int64_t end_ns) {
  const auto after = [&](int64_t time_ns) {
    return std::upper_bound(
        samples.begin(), samples.end(), time_ns,
        [](int64_t time, const ImuSample& sample) { return time < sample.timestamp_ns; });
  };
  auto sample = after(begin_ns);
  if (sample == samples.begin()) {
    return false;
  }
  for (; sample != samples.end(); ++sample) {
    if (sample->timestamp_ns - (sample - 1)->timestamp_ns > kLongestStepNs) {
      return false;
    }
    if (sample->timestamp_ns >= end_ns) {
      return true;
    }
  }
  return (sample - 1)->timestamp_ns >= end_ns;
}

std::vector<FrameInterval> IntegrateIntervals(const Trajectory& frames,
                                              const std::vector<ImuSample>& samples,
                                              const ImuBias& bias, const ImuNoise& noise) {
  std::vector<FrameInterval> intervals;
  intervals.reserve(frames.size());
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    const int64_t begin = frames[i].timestamp_ns;
    const int64_t end = frames[i + 1].timestamp_ns;
    if (IsCovered(samples, begin, end)) {
      intervals.push_back({i, Preintegrate(samples, begin, end, bias, noise)});
    }
  }
  return intervals;
}

double Rms(double sum, Eigen::Index freedom) {
  return std::sqrt(std::max(0.0, sum) / static_cast<double>(std::max<Eigen::Index>(1, freedom)));
}

}  // namespace gluevo::vo
