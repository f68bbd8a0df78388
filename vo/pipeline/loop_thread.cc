#include "gluevo/vo/pipeline/loop_thread.h"

#include <sys/resource.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

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
        options_(options),
        thread_([this] { Run(); }) {}
  ~State() { Close(); }

  bool Add(const StereoFrame& frame, const FrameResult& result, const StereoRig& rig) {
    Item item{{frame.timestamp_ns, {}}, result, rig, {}};
    item.result.tracked_frame = {};
    const bool may_be_kept = LoopRecorder::MayKeep(result);
    if (may_be_kept) {
      item.known = FeaturesKnownOf(memo_.get(), frame, result);
    }
    std::unique_lock lock(mutex_);
    if (may_be_kept && options_.waits) {
      has_room_.wait(lock,
                     [&] { return failure_ != nullptr || with_images_ < options_.max_frames; });
    }
    if (may_be_kept && with_images_ < options_.max_frames && !frame.images[0].empty()) {
      item.frame = frame;
      ++with_images_;
    }
    if (failure_ != nullptr) {
      return false;
    }
    items_.push_back(std::move(item));
    lock.unlock();
    has_items_.notify_one();
    return true;
  }

  void Look(const std::function<void(const LoopRecorder&)>& look) const {
    const std::lock_guard lock(recorder_mutex_);
    look(recorder_);
  }

  std::size_t loops() const { return loops_; }

  void PassOverWaiting() {
    const std::lock_guard lock(mutex_);
    for (Item& item : items_) {
      item.frame.images = {};
    }
    with_images_ = 0;
    has_room_.notify_one();
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

  void Close() {
    {
      const std::lock_guard lock(mutex_);
      is_closed_ = true;
    }
    has_items_.notify_one();
    if (thread_.joinable()) {
      thread_.join();
    }
  }

  void Run() {
    GoBehindOthers();
    while (std::optional<Item> item = Next()) {
      try {
        Stopwatch watch;
        const std::lock_guard lock(recorder_mutex_);
        recorder_.Add(item->frame, item->result, item->rig, std::move(item->known));
        loops_ = recorder_.closer().loops().size();
        took_ms_.push_back(watch.Lap());
      } catch (...) {
        const std::lock_guard lock(mutex_);
        failure_ = std::current_exception();
        items_.clear();
        has_room_.notify_all();
        return;
      }
    }
  }

  std::optional<Item> Next() {
    std::unique_lock lock(mutex_);
    has_items_.wait(lock, [&] { return is_closed_ || !items_.empty(); });
    if (items_.empty()) {
      return std::nullopt;
    }
    std::optional<Item> item = std::move(items_.front());
    items_.pop_front();
    with_images_ -= item->frame.images[0].empty() ? 0 : 1;
    lock.unlock();
    has_room_.notify_one();
    return item;
  }

  LoopRecorder& recorder_;
  const std::shared_ptr<const ExtractorMemo> memo_;
  const LoopThreadOptions options_;
  mutable std::mutex recorder_mutex_;  // Of the recorder.
  std::atomic<std::size_t> loops_ = 0;
  std::vector<double> took_ms_;  // The thread's.
  std::mutex mutex_;             // Of what follows.
  std::condition_variable has_items_, has_room_;
  std::deque<Item> items_;
  std::size_t with_images_ = 0;  // Of them.
  bool is_closed_ = false;
  std::exception_ptr failure_;
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
