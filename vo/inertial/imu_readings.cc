#include "gluevo/vo/inertial/imu_readings.h"

#include <algorithm>
#include <cmath>
#include <optional>
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

void ImuReadings::set_time_offset_s(double time_offset_s) {
  const auto time_offset_ns = static_cast<int64_t>(std::llround(1e9 * time_offset_s));
  for (ImuSample& sample : samples_) {
    sample.timestamp_ns -= time_offset_ns - time_offset_ns_;
  }
  time_offset_ns_ = time_offset_ns;
}

void ImuReadings::Add(std::span<const ImuSample> samples) {
  std::optional<int64_t> before_ns;
  if (!samples_.empty()) {
    before_ns = samples_.back().timestamp_ns + time_offset_ns_;
  }
  for (const ImuSample& sample : samples) {
    if (before_ns && sample.timestamp_ns <= *before_ns) {
      throw Error("inertial reading at " + std::to_string(sample.timestamp_ns) +
                  " ns does not come after the one before, at " + std::to_string(*before_ns) +
                  " ns");
    }
    before_ns = sample.timestamp_ns;
  }
  const auto count = static_cast<std::ptrdiff_t>(samples.size());
  samples_.insert(samples_.end(), samples.begin(), samples.end());
  for (auto sample = samples_.end() - count; sample != samples_.end(); ++sample) {
    sample->timestamp_ns -= time_offset_ns_;
  }
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
  Preintegration measured =
      IsCovered(around, begin_ns, end_ns)
          ? Preintegrate(around, begin_ns, end_ns, bias, noise_)
          : AcrossGap(1e-9 * static_cast<double>(end_ns - begin_ns), bias, noise_);
  measured.time_offset_s = time_offset_s();
  return measured;
}

}  // namespace gluevo::vo
