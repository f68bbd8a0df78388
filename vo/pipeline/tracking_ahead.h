#pragma once

#include <functional>
#include <future>
#include <thread>
#include <utility>

#include "gluevo/vo/core/bounded_queue.h"
#include "gluevo/vo/core/stopwatch.h"
#include "gluevo/vo/core/tracked_frame.h"

namespace gluevo::vo::internal {

/// A thread on which a front end tracks the next frame while this one is estimated.
class TrackingAhead {
 public:
  TrackingAhead()
      : thread_([this] {
          while (auto task = tasks_.Pop()) {
            (*task)();
          }
        }) {}
  ~TrackingAhead() { tasks_.Close(); }
  TrackingAhead(const TrackingAhead&) = delete;
  TrackingAhead& operator=(const TrackingAhead&) = delete;

  struct Tracked {
    TrackedFrame frame;
    double took_ms = 0.0;
  };

  void Begin(std::function<TrackedFrame()> track) {
    std::packaged_task<Tracked()> task([track = std::move(track)] {
      Stopwatch watch;
      Tracked tracked{track(), 0.0};
      tracked.took_ms = watch.Lap();
      return tracked;
    });
    tracked_ = task.get_future();
    tasks_.Push(std::move(task));
  }
  bool has_begun() const { return tracked_.valid(); }
  /// Waits for it; throws what tracking threw.
  Tracked Take() { return tracked_.get(); }

 private:
  BoundedQueue<std::packaged_task<Tracked()>> tasks_{1};
  std::future<Tracked> tracked_;
  std::jthread thread_;  // Last: it uses the others.
};

}  // namespace gluevo::vo::internal
