#include "dataset_source.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "gluevo/nn/error.h"

namespace gluevo::apps {

SourceClock SteadySourceClock() {
  using Clock = std::chrono::steady_clock;
  return {
      [] {
        return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch())
            .count();
      },
      [](int64_t until_ns) {
        std::this_thread::sleep_until(Clock::time_point(std::chrono::nanoseconds(until_ns)));
      }};
}

DatasetSource::DatasetSource(const vo::Dataset& dataset, const DatasetSourceOptions& options,
                             SourceClock clock)
    : dataset_(dataset),
      options_(options),
      clock_(std::move(clock)),
      // Where it turns round, an image counts once.
      frames_(1 + (dataset.entries.size() - 1) * static_cast<std::size_t>(options.rounds)),
      first_ns_(dataset.entries.front().timestamp_ns) {
  if (options_.gives_readings && dataset_.imu) {
    const std::vector<vo::ImuSample>& samples = dataset_.imu->samples;
    const auto first = std::lower_bound(
        samples.begin(), samples.end(), first_ns_,
        [](const vo::ImuSample& sample, int64_t time) { return sample.timestamp_ns < time; });
    // Those before the first frame are known when it comes.
    first_ns_ =
        std::min(first_ns_, first == samples.begin() ? first_ns_ : (first - 1)->timestamp_ns);
    next_reading_ =
        static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, first - samples.begin() - 1));
  }
  start_ns_ = clock_.now_ns();
}

std::size_t DatasetSource::IndexOf(std::size_t frame) const {
  const std::size_t last = dataset_.entries.size() - 1;
  if (last == 0) {
    return 0;
  }
  const std::size_t step = frame % (2 * last);
  return step <= last ? step : 2 * last - step;
}

int64_t DatasetSource::StampOf(std::size_t frame) const {
  const std::size_t last = dataset_.entries.size() - 1;
  const int64_t begin = dataset_.entries.front().timestamp_ns;
  if (frame <= last) {
    return dataset_.entries[frame].timestamp_ns;
  }
  const int64_t length = dataset_.entries.back().timestamp_ns - begin;
  const std::size_t round = frame / last;
  const int64_t along = dataset_.entries[IndexOf(frame)].timestamp_ns - begin;
  return begin + static_cast<int64_t>(round) * length + (round % 2 == 0 ? along : length - along);
}

int64_t DatasetSource::DueAt(int64_t stamp_ns) const {
  return start_ns_ + static_cast<int64_t>(
                         std::llround(static_cast<double>(stamp_ns - first_ns_) / options_.pace));
}

int64_t DatasetSource::Now() const {
  return first_ns_ + static_cast<int64_t>(std::llround(
                         static_cast<double>(clock_.now_ns() - start_ns_) * options_.pace));
}

bool DatasetSource::Wait(int64_t stamp_ns) const {
  constexpr int64_t kLongestNs = 100'000'000;
  const int64_t due_ns = DueAt(stamp_ns);
  const int64_t now_ns = clock_.now_ns();
  if (now_ns < due_ns) {
    clock_.sleep_until(std::min(due_ns, now_ns + kLongestNs));
  }
  return due_ns - now_ns <= kLongestNs;
}

void DatasetSource::ReadNext(SourceEvent& event) {
  while (next_ + 1 < frames_ && DueAt(StampOf(next_ + 1)) <= clock_.now_ns()) {
    ++next_;
    ++counts_.frames_late;
  }
  try {
    image_ = dataset_.Read(IndexOf(next_));
    image_->timestamp_ns = StampOf(next_);
  } catch (const Error& error) {
    event.left_out = error.what();
    event.frame_index = next_++;
  }
}

SourceEvent DatasetSource::GiveReadings(int64_t last_ns) {
  const std::vector<vo::ImuSample>& samples = dataset_.imu->samples;
  SourceEvent event;
  if (!Wait(samples[next_reading_].timestamp_ns)) {
    return event;
  }
  const int64_t now_ns = clock_.now_ns();
  while (next_reading_ < samples.size() && samples[next_reading_].timestamp_ns <= last_ns &&
         DueAt(samples[next_reading_].timestamp_ns) <= now_ns) {
    event.readings.push_back(samples[next_reading_++]);
  }
  awaits_reading_ = false;
  return event;
}

SourceEvent DatasetSource::Next() {
  const bool has_readings =
      options_.gives_readings && dataset_.imu && next_reading_ < dataset_.imu->samples.size();
  SourceEvent event;
  if (has_readings && awaits_reading_) {
    return GiveReadings(dataset_.imu->samples[next_reading_].timestamp_ns);
  }
  if (next_ == frames_) {
    event.is_end = true;
    return event;
  }
  if (!image_) {
    ReadNext(event);
    return event;
  }
  if (has_readings && dataset_.imu->samples[next_reading_].timestamp_ns <= image_->timestamp_ns) {
    return GiveReadings(image_->timestamp_ns);
  }
  if (Wait(image_->timestamp_ns)) {
    event.frame = std::exchange(image_, std::nullopt);
    ++next_;
    awaits_reading_ = true;
  }
  return event;
}

}  // namespace gluevo::apps
