#include "gluevo/vo/pipeline/live_pipeline.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/bounded_queue.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/core/stopwatch.h"
#include "latency_histogram.h"
#include "stamp_watch.h"

namespace gluevo::vo {
namespace {

using SteadyClock = std::chrono::steady_clock;

// A minute of a fast unit's: without frames nobody takes them.
constexpr std::size_t kMostReadings = 60'000;
constexpr std::size_t kResultsThatWait = 2;  // Each is later by the time of those before it.

}  // namespace

void LiveOptions::Validate() const {
  CheckAtLeast(queue_frames, 1, "live.queue_frames");
  CheckPositive(max_age_s, "live.max_age_s");
  CheckWithin(imu_wait_s, 0.0, 10.0, "live.imu_wait_s");
}

class LivePipeline::State {
 public:
  State(Odometry odometry, LiveCallbacks callbacks, Clock clock, const LiveOptions& options)
      : odometry_(std::move(odometry)),
        callbacks_(std::move(callbacks)),
        clock_(std::move(clock)),
        options_(options),
        frames_(static_cast<std::size_t>(options.queue_frames)),
        results_(kResultsThatWait),
        tracker_([this] { TrackAll(); }),
        teller_([this] { TellAll(); }) {}

  void Push(StereoFrame frame);
  void Push(std::span<const ImuSample> samples);
  LiveStatistics statistics() const;
  void Join();
  const std::exception_ptr& failure() const { return failure_; }
  const Odometry& odometry() const { return odometry_; }

 private:
  template <typename Work>
  void Guard(const Work& work);
  void TrackAll();
  void TellAll();
  void Track(StereoFrame frame);
  /// Waits for the frame's readings; a newer one takes its place where it is too old by then.
  void MakeReady(StereoFrame& frame);
  bool GiveWayToNewer(StereoFrame& frame);
  /// Gives the odometry the readings, those for a frame of this time among them.
  void TakeReadings(int64_t timestamp_ns);
  bool HasReadingsTo(int64_t timestamp_ns) const;
  void Warn(const std::string& warning);

  Odometry odometry_;
  const LiveCallbacks callbacks_;
  const Clock clock_;
  const LiveOptions options_;
  BoundedQueue<StereoFrame> frames_;
  BoundedQueue<LiveResult> results_;

  mutable std::mutex mutex_;  // Of all that follows.
  std::condition_variable readings_came_;
  LiveStatistics counts_;
  internal::LatencyHistogram latency_;
  internal::StampWatch frame_stamps_{"camera"};
  internal::StampWatch reading_stamps_{"inertial unit"};
  std::vector<ImuSample> readings_;
  std::optional<int64_t> newest_reading_ns_;
  SteadyClock::time_point reading_came_;
  bool is_finishing_ = false;
  std::exception_ptr failure_;

  std::mutex warning_mutex_;
  std::jthread tracker_, teller_;  // Last: they use the others.
};

void LivePipeline::State::Push(StereoFrame frame) {
  std::string warning;
  {
    const std::lock_guard lock(mutex_);
    ++counts_.frames_pushed;
    internal::StampWatch::Judged judged =
        frame_stamps_.Judge(frame.timestamp_ns, clock_(), reading_stamps_.shift_ns());
    warning = std::move(judged.warning);
    frame.timestamp_ns = judged.timestamp_ns.value_or(frame.timestamp_ns);
    if (judged.timestamp_ns && frames_.PushDroppingOldest(std::move(frame))) {
      ++counts_.frames_dropped;
    }
  }
  Warn(warning);
}

void LivePipeline::State::Push(std::span<const ImuSample> samples) {
  std::string warning;
  {
    const std::lock_guard lock(mutex_);
    for (ImuSample sample : samples) {
      internal::StampWatch::Judged judged =
          reading_stamps_.Judge(sample.timestamp_ns, clock_(), frame_stamps_.shift_ns());
      warning = judged.warning.empty() ? std::move(warning) : std::move(judged.warning);
      if (!judged.timestamp_ns || readings_.size() == kMostReadings) {
        ++counts_.readings_left_out;
        continue;
      }
      sample.timestamp_ns = *judged.timestamp_ns;
      newest_reading_ns_ = sample.timestamp_ns;
      readings_.push_back(sample);
    }
    reading_came_ = SteadyClock::now();
  }
  readings_came_.notify_all();
  Warn(warning);
}

LiveStatistics LivePipeline::State::statistics() const {
  const std::lock_guard lock(mutex_);
  LiveStatistics statistics = counts_;
  statistics.stamps_still = frame_stamps_.still();
  statistics.stamps_back = frame_stamps_.back();
  statistics.clock_steps = frame_stamps_.steps() + reading_stamps_.steps();
  statistics.latency_median_ms = latency_.Quantile(0.5);
  statistics.latency_p95_ms = latency_.Quantile(0.95);
  statistics.latency_max_ms = latency_.max_ms();
  return statistics;
}

void LivePipeline::State::Join() {
  {
    const std::lock_guard lock(mutex_);
    is_finishing_ = true;
  }
  readings_came_.notify_all();
  frames_.Close();
  if (tracker_.joinable()) {
    tracker_.join();
  }
  results_.Close();
  if (teller_.joinable()) {
    teller_.join();
  }
}

template <typename Work>
void LivePipeline::State::Guard(const Work& work) {
  try {
    work();
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = failure_ ? failure_ : std::current_exception();
  }
  // Where all is well these are empty and closed already, or about to be.
  frames_.Close();
  results_.Close();
}

void LivePipeline::State::TrackAll() {
  Guard([this] {
    // None is announced to the odometry: that would give more frames, but each one later.
    while (std::optional<StereoFrame> frame = frames_.Pop()) {
      Track(*std::move(frame));
    }
  });
}

void LivePipeline::State::TellAll() {
  Guard([this] {
    while (std::optional<LiveResult> result = results_.Pop()) {
      result->latency_ms = 1e-6 * static_cast<double>(clock_() - result->frame.timestamp_ns);
      {
        const std::lock_guard lock(mutex_);
        latency_.Add(result->latency_ms);
      }
      if (callbacks_.result) {
        callbacks_.result(*result);
      }
    }
  });
}

void LivePipeline::State::Track(StereoFrame frame) {
  LiveResult result;
  try {
    MakeReady(frame);
    result.result = odometry_.Process(frame);
  } catch (const Error& error) {
    {
      const std::lock_guard lock(mutex_);
      ++counts_.frames_refused;
    }
    Warn(std::string("frame left out: ") + error.what());
    return;
  }
  if (callbacks_.tracked) {
    callbacks_.tracked(frame, result.result, odometry_);
  }
  result.frame = std::move(frame);
  {
    const std::lock_guard lock(mutex_);
    ++counts_.frames_tracked;
  }
  results_.Push(std::move(result));
}

void LivePipeline::State::MakeReady(StereoFrame& frame) {
  do {
    while (GiveWayToNewer(frame)) {
    }
    TakeReadings(frame.timestamp_ns);
  } while (GiveWayToNewer(frame));
}

bool LivePipeline::State::GiveWayToNewer(StereoFrame& frame) {
  const bool is_old = SecondsBetween(frame.timestamp_ns, clock_()) > options_.max_age_s;
  std::optional<StereoFrame> newer = is_old ? frames_.TryPop() : std::nullopt;
  if (!newer) {
    return false;
  }
  frame = *std::move(newer);
  const std::lock_guard lock(mutex_);
  ++counts_.frames_dropped;
  ++counts_.frames_dropped_old;
  return true;
}

bool LivePipeline::State::HasReadingsTo(int64_t timestamp_ns) const {
  const double offset_s = odometry_.inertial()->readings().time_offset_s();
  return newest_reading_ns_ &&
         *newest_reading_ns_ - static_cast<int64_t>(1e9 * offset_s) >= timestamp_ns;
}

void LivePipeline::State::TakeReadings(int64_t timestamp_ns) {
  constexpr auto kSilence = std::chrono::seconds(1);
  std::vector<ImuSample> readings;
  {
    std::unique_lock lock(mutex_);
    if (odometry_.inertial() != nullptr && newest_reading_ns_ &&
        SteadyClock::now() - reading_came_ < kSilence) {
      Stopwatch watch;
      readings_came_.wait_for(lock, std::chrono::duration<double>(options_.imu_wait_s),
                              [&] { return is_finishing_ || HasReadingsTo(timestamp_ns); });
      counts_.readings_wait_ms += watch.Lap();
    }
    readings.swap(readings_);
    if (odometry_.inertial() == nullptr) {
      counts_.readings_left_out += static_cast<int64_t>(readings.size());
      return;
    }
  }
  odometry_.AddImu(readings);
}

void LivePipeline::State::Warn(const std::string& warning) {
  if (!warning.empty() && callbacks_.warning) {
    const std::lock_guard lock(warning_mutex_);
    callbacks_.warning(warning);
  }
}

LivePipeline::LivePipeline(Odometry odometry, LiveCallbacks callbacks, Clock clock,
                           const LiveOptions& options) {
  options.Validate();
  state_ =
      std::make_unique<State>(std::move(odometry), std::move(callbacks), std::move(clock), options);
}

LivePipeline::~LivePipeline() { state_->Join(); }

void LivePipeline::Push(StereoFrame frame) { state_->Push(std::move(frame)); }
void LivePipeline::Push(std::span<const ImuSample> samples) { state_->Push(samples); }

LiveStatistics LivePipeline::statistics() const { return state_->statistics(); }

LiveStatistics LivePipeline::Finish() {
  state_->Join();
  if (state_->failure()) {
    std::rethrow_exception(state_->failure());
  }
  return state_->statistics();
}

const Odometry& LivePipeline::odometry() const { return state_->odometry(); }

}  // namespace gluevo::vo
