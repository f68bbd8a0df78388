#include "gluevo/vo/inertial/imu_readings.h"

#include <algorithm>
#include <string>

#include "frame_intervals.h"
#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

// The first sample at the time or after it.
template <typename Samples>
auto At(Samples& samples, int64_t time_ns) {
  return std::lower_bound(
      samples.begin(), samples.end(), time_ns,
      [](const ImuSample& sample, int64_t time) { return sample.timestamp_ns < time; });
}

}  // namespace

ImuReadings::ImuReadings(const ImuNoise& noise) : noise_(noise) { noise_.Validate(); }

void ImuReadings::set_noise(const ImuNoise& noise) {
  noise.Validate();
  noise_ = noise;
}

void ImuReadings::Add(std::span<const ImuSample> samples) {
  const ImuSample* before = samples_.empty() ? nullptr : &samples_.back();
  for (const ImuSample& sample : samples) {
    if (before != nullptr && sample.timestamp_ns <= before->timestamp_ns) {
      throw Error("inertial reading at " + std::to_string(sample.timestamp_ns) +
                  " ns does not come after the one before, at " +
                  std::to_string(before->timestamp_ns) + " ns");
    }
    before = &sample;
  }
  samples_.insert(samples_.end(), samples.begin(), samples.end());
}

void ImuReadings::ForgetBefore(int64_t time_ns) {
  const auto first = At(samples_, time_ns);
  // The one before is interpolated from. All that stay are moved: seldom.
  constexpr std::ptrdiff_t kMany = 1024;
  if (first - samples_.begin() > kMany) {
    samples_.erase(samples_.begin(), first - 1);
  }
}

std::vector<ImuSample> ImuReadings::Around(int64_t begin_ns, int64_t end_ns) const {
  const auto begin = At(samples_, begin_ns);
  const auto end = At(samples_, end_ns);
  return {begin == samples_.begin() ? begin : begin - 1, end == samples_.end() ? end : end + 1};
}

bool ImuReadings::Cover(int64_t begin_ns, int64_t end_ns) const {
  return IsCovered(Around(begin_ns, end_ns), begin_ns, end_ns);
}

Preintegration ImuReadings::Between(int64_t begin_ns, int64_t end_ns, const ImuBias& bias) const {
  if (begin_ns >= end_ns) {
    throw Error("inertial readings: an interval that does not end after it begins");
  }
  const std::vector<ImuSample> around = Around(begin_ns, end_ns);
  if (!IsCovered(around, begin_ns, end_ns)) {
    return AcrossGap(1e-9 * static_cast<double>(end_ns - begin_ns), bias, noise_);
  }
  return Preintegrate(around, begin_ns, end_ns, bias, noise_);
}

}  // namespace gluevo::vo
