#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "gluevo/vo/core/frame_result.h"
#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/pipeline/odometry.h"

namespace gluevo::vo {

struct LiveOptions {
  /// So many frames wait at most while one is tracked; for a newer one the oldest is dropped.
  int queue_frames = 4;
  /// A frame that is older than this, seconds on the caller's clock, when its turn comes, or once
  /// its readings are there, is dropped where a newer one waits: so late no pose gets.
  double max_age_s = 0.1;
  /// Where an inertial unit is used a frame waits for its readings up to the frame's time, at most
  /// so long, seconds of real time; not at all where none has come for a second.
  double imu_wait_s = 0.05;

  /// Throws Error naming the option.
  void Validate() const;
};

/// What happened so far.
struct LiveStatistics {
  int64_t frames_pushed = 0;
  int64_t frames_tracked = 0;
  int64_t frames_dropped = 0;      ///< For newer ones, since tracking was not done.
  int64_t frames_dropped_old = 0;  ///< Of these, those that were too old when their turn came.
  int64_t frames_refused = 0;      ///< The odometry threw (images of another size ...).
  int64_t stamps_still = 0;        ///< Frames left out whose time is that of the one before.
  int64_t stamps_back = 0;         ///< Frames left out whose time is a little before that.
  int64_t clock_steps = 0;        ///< How often stamps jumped, back or ahead: they go on as if not.
  int64_t readings_left_out = 0;  ///< Of the inertial unit: out of order, or none took them.
  double readings_wait_ms = 0.0;  ///< Frames have waited for readings, all together.
  /// From a frame's stamp to the call of LiveCallbacks::result, by the caller's clock,
  /// milliseconds; percentiles to one per cent. 0 before the first.
  double latency_median_ms = 0.0;
  double latency_p95_ms = 0.0;
  double latency_max_ms = 0.0;
};

struct LiveResult {
  /// As it was pushed; its time, and the result's, are as they go on where a clock stepped.
  StereoFrame frame;
  FrameResult result;
  double latency_ms = 0.0;
};

/// Each may be empty. One that throws ends the tracking; Finish() throws what it threw.
struct LiveCallbacks {
  /// On the tracking thread, after each tracked frame: whoever takes long here delays the next one.
  /// May note the time of stages in the result.
  std::function<void(const StereoFrame&, FrameResult&, const Odometry&)> tracked;
  /// On a thread of its own, in the frames' order. Where it is slower than tracking, tracking waits
  /// and drops frames.
  std::function<void(const LiveResult&)> result;
  /// A sentence for people on what goes wrong and is survived, once a time it begins. On any
  /// thread, one call at a time.
  std::function<void(const std::string&)> warning;
};

/// Odometry as things happen: whoever has frames and readings pushes them and never waits; poses
/// come by callbacks. Tracking and results have a thread each. Where no frame is dropped results
/// are Odometry's, bit for bit.
class LivePipeline {
 public:
  /// The time now, nanoseconds, on the clock that stamps the frames.
  using Clock = std::function<int64_t()>;

  /// Throws Error for options out of their range. For an inertial unit the odometry has to be told
  /// (Odometry::UseImu).
  LivePipeline(Odometry odometry, LiveCallbacks callbacks, Clock clock,
               const LiveOptions& options = {});
  /// As Finish(), but silent.
  ~LivePipeline();
  LivePipeline(const LivePipeline&) = delete;
  LivePipeline& operator=(const LivePipeline&) = delete;

  /// The next stereo pair. The images' memory must not be written any more. Returns at once, as the
  /// next ones; each may be called by a thread of its own.
  void Push(StereoFrame frame);
  /// The next readings of the inertial unit.
  void Push(std::span<const ImuSample> samples);
  void Push(const ImuSample& sample) { Push(std::span(&sample, 1)); }

  LiveStatistics statistics() const;

  /// Frames that wait are tracked, results given out, threads ended; what is pushed later is
  /// dropped. Throws what a callback threw.
  LiveStatistics Finish();

  /// To be used after Finish(), or in LiveCallbacks::tracked.
  const Odometry& odometry() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace gluevo::vo
