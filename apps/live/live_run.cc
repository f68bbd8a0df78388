#include "live_run.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <exception>
#include <iostream>
#include <utility>

#include "command_line/message.h"
#include "gluevo/vo/core/stopwatch.h"
#include "interruption.h"

namespace gluevo::apps {
namespace {

constexpr int64_t kStatusEveryNs = 10'000'000'000;

// Whoever reads standard output is waited for, but not beyond a wish to end.
bool TakesALine() {
  constexpr int kPatienceMs = 100;
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  while (Interruption::signal() == 0) {
    const int ready = poll(&output, 1, kPatienceMs);
    if (ready > 0 || (ready < 0 && errno != EINTR)) {
      return true;
    }
  }
  return poll(&output, 1, 0) > 0;
}

void Warn(const std::string& warning) { PrintMessage("gluevo: warning", warning); }

}  // namespace

LiveRun::LiveRun(LiveParts parts, vo::Odometry odometry, const vo::LiveOptions& options)
    : parts_(std::move(parts)),
      pipeline_(std::make_unique<vo::LivePipeline>(
          std::move(odometry),
          vo::LiveCallbacks{
              .tracked = [this](const vo::StereoFrame& frame, vo::FrameResult& result,
                                const vo::Odometry& tracker) { Tracked(frame, result, tracker); },
              .result = [this](const vo::LiveResult& live) { Publish(live); },
              .warning = Warn},
          [this] { return parts_.source.Now(); }, options)) {
  if (RunRecords& records = parts_.records; records.loops) {
    loop_thread_.emplace(*records.loops, records.extracted, vo::LoopThreadOptions{.waits = false});
  }
}

// On the tracking thread.
void LiveRun::Tracked(const vo::StereoFrame& frame, vo::FrameResult& result,
                      const vo::Odometry& odometry) {
  RunRecords& records = parts_.records;
  if (loop_thread_) {
    loop_thread_->Add(frame, result, odometry.rig());
  }
  records.metrics.FrameIsDone(result);
  if (parts_.view) {
    ShowTracked(result, odometry);
  }
}

void LiveRun::ShowTracked(const vo::FrameResult& result, const vo::Odometry& odometry) {
  if (result.is_keyframe) {
    parts_.view->ShowLandmarks(odometry.MapPoints());
  }
  if (loop_thread_) {
    const std::size_t closed = loop_thread_->loops();
    if (std::exchange(loops_, closed) < closed) {
      parts_.view->PlaceIsRecognised();
    }
  }
  if (parts_.view->TakeSaveWish()) {
    loop_thread_->Look(
        [&](const vo::LoopRecorder& /*loops*/) { parts_.view->Say(parts_.save_map()); });
  }
}

// On the thread of results.
void LiveRun::Publish(const vo::LiveResult& live) {
  const std::string line = TumLine({live.result.timestamp_ns, live.result.world_from_body});
  if (parts_.prints_poses && TakesALine()) {
    std::cout << line << std::flush;
  }
  for (const std::unique_ptr<LinePublisher>& publisher : parts_.publishers) {
    publisher->Publish(line);
  }
  if (parts_.view) {
    const vo::LiveStatistics statistics = pipeline_->statistics();
    parts_.view->Show(live, statistics, statistics.frames_dropped + late_);
  }
  parts_.records.diagnosis.Add(live.frame, live.result);
  parts_.records.strip.Add(live.result, [&] { return live.frame; });
}

bool LiveRun::Take(SourceEvent event) {
  if (event.is_end) {
    return false;
  }
  if (!event.warning.empty()) {
    Warn(event.warning);
  }
  if (!event.left_out.empty()) {
    Warn("frame left out: " + event.left_out);
    left_out_.push_back({event.frame_index, std::move(event.left_out)});
  }
  if (!event.readings.empty()) {
    pipeline_->Push(event.readings);
  }
  if (parts_.view && parts_.view->is_paused()) {
    record_.frames_paused += event.frame ? 1 : 0;
    parts_.view->ShowPaused();
  } else if (event.frame) {
    pipeline_->Push(*std::move(event.frame));
  }
  return true;
}

void LiveRun::TellStatus(int64_t since_begin_ns) {
  if (since_begin_ns < next_status_ns_) {
    return;
  }
  next_status_ns_ += kStatusEveryNs;
  const vo::LiveStatistics statistics = pipeline_->statistics();
  if (statistics.frames_tracked > 0) {
    char line[160];
    std::snprintf(line, sizeof(line),
                  "%.0f s: %lld frames, %lld dropped; latency %.0f ms, 95 of 100 below %.0f ms",
                  1e-9 * static_cast<double>(since_begin_ns),
                  static_cast<long long>(statistics.frames_tracked),
                  static_cast<long long>(statistics.frames_dropped) +
                      static_cast<long long>(parts_.source.counts().frames_late),
                  statistics.latency_median_ms, statistics.latency_p95_ms);
    std::cerr << line << '\n';
  }
}

LiveEnd LiveRun::Run() {
  LiveEnd live;
  parts_.records.metrics.Start();
  const int64_t begin_ns = parts_.source.Now();
  try {
    while (Interruption::signal() == 0) {
      const int64_t since_ns = parts_.source.Now() - begin_ns;
      if (parts_.duration_s && 1e-9 * static_cast<double>(since_ns) >= *parts_.duration_s) {
        break;
      }
      TellStatus(since_ns);
      if (!Take(parts_.source.Next())) {
        live.is_whole = true;
        break;
      }
      late_ = parts_.source.counts().frames_late;
    }
  } catch (const std::exception& error) {  // What is done is not lost, whatever fails.
    live.end.failure = error.what();
  }
  live.end.signal = live.is_whole ? 0 : Interruption::signal();
  try {
    pipeline_->Finish();
  } catch (const std::exception& error) {
    live.end.failure = live.end.failure.empty() ? error.what() : live.end.failure;
  }
  try {
    if (loop_thread_) {
      if (live.end.signal != 0) {
        loop_thread_->PassOverWaiting();
      }
      parts_.records.metrics.AddStage("loops", loop_thread_->Finish());
    }
  } catch (const std::exception& error) {
    live.end.failure = live.end.failure.empty() ? error.what() : live.end.failure;
  }
  if (parts_.view) {
    parts_.view->ShowEnded();
  }
  GatherRecords();
  record_.statistics = pipeline_->statistics();
  record_.source = parts_.source.counts();
  return live;
}

// What took no memory until now.
void LiveRun::GatherRecords() {
  RunRecords& records = parts_.records;
  records.metrics.LoadFrames();
  for (const vo::FrameResult& frame : records.metrics.frames()) {
    records.trajectory.push_back({frame.timestamp_ns, frame.world_from_body});
    if (frame.is_keyframe) {
      records.keyframes.push_back(records.trajectory.back());
    }
  }
  for (const LeftOut& one : left_out_) {
    records.metrics.FrameIsLeftOut(one.frame, one.why);
  }
}

}  // namespace gluevo::apps
