#include "gluevo/vo/pipeline/loop_thread.h"

#include <sys/resource.h>

#include <atomic>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "gluevo/vo/core/bounded_queue.h"
#include "gluevo/vo/core/stopwatch.h"

namespace gluevo::vo {
namespace {

// A quarter of a processor that one other thread wants, too: less, and where a machine is busy with
// other things, too, tracking waits for loops without end.
constexpr int kNiceness = 5;

// On Linux of the calling thread alone, and of those that it starts.
void GoBehindOthers() { setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + kNiceness); }

}  // namespace

KnownFeatures FeaturesKnownOf(const ExtractorMemo* memo, const StereoFrame& frame,
                              const FrameResult& result) {
  KnownFeatures known;
  for (std::size_t side = 0; memo != nullptr && side < known.size(); ++side) {
    if (LoopRecorder::MayKeep(result) && !frame.images[side].empty()) {
      known[side] = memo->Known(frame.images[side]);
    }
  }
  return known;
}

std::unique_ptr<nn::ThreadPool> MakeBackgroundPool(int threads) {
  std::unique_ptr<nn::ThreadPool> pool;
  std::exception_ptr failure;
  std::jthread([&] {
    try {
      GoBehindOthers();
      pool = std::make_unique<nn::ThreadPool>(threads);
    } catch (...) {
      failure = std::current_exception();
    }
  }).join();
  if (failure != nullptr) {
    std::rethrow_exception(failure);
  }
  return pool;
}

class LoopThread::State {
 public:
  State(LoopRecorder& recorder, std::shared_ptr<const ExtractorMemo> memo,
        const LoopThreadOptions& options)
      : recorder_(recorder),
        memo_(std::move(memo)),
        waits_(options.waits),
        items_(options.max_frames, WeightOf),
        thread_([this] { Run(); }) {}
  ~State() { Close(); }

  bool Add(const StereoFrame& frame, const FrameResult& result, const StereoRig& rig) {
    Item item{{frame.timestamp_ns, {}}, result, rig, {}};
    item.result.tracked_frame = {};
    if (LoopRecorder::MayKeep(result)) {
      item.known = FeaturesKnownOf(memo_.get(), frame, result);
      if (waits_ || items_.has_room()) {
        item.frame = frame;
      }
    }
    return items_.Push(std::move(item));
  }

  void Look(const std::function<void(const LoopRecorder&)>& look) const {
    const std::lock_guard lock(recorder_mutex_);
    look(recorder_);
  }

  std::size_t loops() const { return loops_; }

  void PassOverWaiting() {
    items_.ForEach([](Item& item) { item.frame.images = {}; });
  }

  std::vector<double> Finish() {
    Close();
    if (failure_ != nullptr) {
      std::rethrow_exception(failure_);
    }
    return std::move(took_ms_);
  }

 private:
  struct Item {
    StereoFrame frame;
    FrameResult result;
    StereoRig rig;
    KnownFeatures known;
  };

  // Images are what takes memory.
  static std::size_t WeightOf(const Item& item) { return item.frame.images[0].empty() ? 0 : 1; }

  void Close() {
    items_.Close();
    if (thread_.joinable()) {
      thread_.join();
    }
  }

  void Run() {
    GoBehindOthers();
    try {
      while (std::optional<Item> item = items_.Pop()) {
        Stopwatch watch;
        const std::lock_guard lock(recorder_mutex_);
        recorder_.Add(item->frame, item->result, item->rig, std::move(item->known));
        loops_ = recorder_.closer().loops().size();
        took_ms_.push_back(watch.Lap());
      }
    } catch (...) {
      failure_ = std::current_exception();
      items_.Close();
    }
  }

  LoopRecorder& recorder_;
  const std::shared_ptr<const ExtractorMemo> memo_;
  const bool waits_;
  mutable std::mutex recorder_mutex_;  // Of the recorder.
  std::atomic<std::size_t> loops_ = 0;
  std::vector<double> took_ms_;  // The thread's, as the next.
  std::exception_ptr failure_;
  BoundedQueue<Item> items_;
  std::jthread thread_;  // Last: it uses the others.
};

LoopThread::LoopThread(LoopRecorder& recorder, std::shared_ptr<const ExtractorMemo> memo,
                       const LoopThreadOptions& options)
    : state_(std::make_unique<State>(recorder, std::move(memo), options)) {}

LoopThread::~LoopThread() = default;

bool LoopThread::Add(const StereoFrame& frame, const FrameResult& result, const StereoRig& rig) {
  return state_->Add(frame, result, rig);
}

void LoopThread::Look(const std::function<void(const LoopRecorder&)>& look) const {
  state_->Look(look);
}

void LoopThread::PassOverWaiting() { state_->PassOverWaiting(); }

std::size_t LoopThread::loops() const { return state_->loops(); }

std::vector<double> LoopThread::Finish() { return state_->Finish(); }

}  // namespace gluevo::vo
