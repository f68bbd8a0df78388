#include "gluevo/nn/thread_pool.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "gluevo/nn/error.h"

namespace gluevo::nn {
namespace {

using Clock = std::chrono::steady_clock;

// To wake a sleeping thread takes some 50 us, and the loops of a network follow each other within
// less: a thread that waits spins for a few times that before it sleeps. A time, because a pause
// takes from 1 to 140 cycles, depending on the CPU.
constexpr auto kSpinTime = std::chrono::microseconds(200);
constexpr int kPausesPerClock = 32;

void Pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Waits for done() for at most `time`, or until futile(), which is asked now and then. Returns
// done().
template <typename Done, typename Futile>
bool SpinUntil(std::chrono::nanoseconds time, const Done& done, const Futile& futile) {
  if (done()) {
    return true;
  }
  const Clock::time_point end = Clock::now() + time;
  while (Clock::now() < end && !futile()) {
    for (int i = 0; i < kPausesPerClock; ++i) {
      Pause();
      if (done()) {
        return true;
      }
    }
  }
  return done();
}

int AvailableProcessors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) == 0 && CPU_COUNT(&set) > 0) {
    return CPU_COUNT(&set);
  }
  return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

// A loop's state in one word, so that joining it, leaving it and closing it are each one step:
// its number, whether workers may join, whether the caller sleeps until they have left, and how
// many are in it.
constexpr uint64_t kMembers = 0xffff;
constexpr uint64_t kOpen = 1 << 16;
constexpr uint64_t kCallerSleeps = 1 << 17;
constexpr uint64_t kStop = 1 << 18;
constexpr uint64_t kNumber = 1 << 19;  // One of it.

constexpr int kMostThreads = 4096;

}  // namespace

// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): apart on purpose
struct ThreadPool::State {
  std::mutex run_mutex;  // One loop at a time.

  // The loop. Written before it opens; read by its members only.
  int64_t count = 0;
  Function function = nullptr;
  void* body = nullptr;

  std::mutex sleep_mutex;
  std::condition_variable wake;      // Workers sleep here,
  std::condition_variable all_left;  // and here the caller.

  std::chrono::nanoseconds spin_time = kSpinTime;
  std::vector<std::thread> workers;

  // Each on a cache line of its own: all threads write them.
  alignas(64) std::atomic<uint64_t> loop = 0;
  alignas(64) std::atomic<int64_t> next = 0;
  // Workers that sleep or are about to. A worker counts itself, then looks at `loop`; the caller
  // writes `loop`, then looks at the count. In the one order of sequentially consistent operations
  // one of the two sees the other.
  alignas(64) std::atomic<int> sleepers = 0;
  std::atomic<int> caller_processor = -1;  // When it started the loop.

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    Publish(loop.load() | kStop);
    for (std::thread& worker : workers) {
      worker.join();
    }
  }

  // Makes `value` the state of the loop and sees to it that all workers notice.
  void Publish(uint64_t value) {
    loop.store(value);
    if (sleepers.load() > 0) {
      // Whoever holds the mutex has not looked at the loop yet, or sleeps before it is released.
      { const std::lock_guard lock(sleep_mutex); }
      wake.notify_all();
    }
  }

  void Drain(int worker) {
    const int64_t end = count;
    for (int64_t i = next.fetch_add(1, std::memory_order_relaxed); i < end;
         i = next.fetch_add(1, std::memory_order_relaxed)) {
      function(body, i, worker);
    }
  }

  void Work(int worker) {
    uint64_t last = 0;  // Number of the last loop that this worker has drained.
    const auto called = [&] {
      const uint64_t state = loop.load();
      return (state & kStop) != 0 || ((state & kOpen) != 0 && state / kNumber != last);
    };
    // A busy system wakes a worker on the caller's processor, where it holds up what it waits for.
    const auto in_the_way = [&] {
      return sched_getcpu() == caller_processor.load(std::memory_order_relaxed);
    };
    while (true) {
      if (!SpinUntil(spin_time, called, in_the_way)) {
        std::unique_lock lock(sleep_mutex);
        sleepers.fetch_add(1);
        wake.wait(lock, called);
        sleepers.fetch_sub(1);
      }
      uint64_t state = loop.load();
      if ((state & kStop) != 0) {
        return;
      }
      // A worker that comes when the loop is closed has missed nothing: the caller waits for the
      // members only.
      while ((state & kOpen) != 0 && state / kNumber != last) {
        if (loop.compare_exchange_weak(state, state + 1)) {
          last = state / kNumber;
          Drain(worker);
          Leave();
        }
      }
    }
  }

  void Leave() {
    const uint64_t before = loop.fetch_sub(1);
    if ((before & kCallerSleeps) != 0 && (before & kMembers) == 1) {
      { const std::lock_guard lock(sleep_mutex); }
      all_left.notify_one();
    }
  }

  void Close() {
    const auto no_members = [&] { return (loop.load() & kMembers) == 0; };
    loop.fetch_and(~kOpen);
    if (SpinUntil(spin_time, no_members, [] { return false; })) {
      return;
    }
    // The system has preempted a member inside its last index. Asleep, this thread leaves it a
    // processor to go on with; spinning or yielding, it would keep it from being moved here.
    std::unique_lock lock(sleep_mutex);
    loop.fetch_or(kCallerSleeps);
    all_left.wait(lock, no_members);
  }
};

ThreadPool::ThreadPool(int threads) : state_(std::make_unique<State>()) {
  const int processors = AvailableProcessors();
  const int count = threads > 0 ? threads : processors;
  if (count > kMostThreads) {
    throw Error(std::to_string(count) + " threads are too many: expected at most " +
                std::to_string(kMostThreads));
  }
  if (count > processors) {
    state_->spin_time = {};  // Who spins keeps the processor from who works.
  }
  state_->workers.reserve(static_cast<std::size_t>(count) - 1);
  for (int worker = 1; worker < count; ++worker) {
    try {
      state_->workers.emplace_back([state = state_.get(), worker] { state->Work(worker); });
    } catch (const std::system_error& error) {
      throw Error("cannot start thread " + std::to_string(worker + 1) + " of " +
                  std::to_string(count) + ": " + error.what());
    }
  }
}

ThreadPool::~ThreadPool() = default;

int ThreadPool::size() const { return static_cast<int>(state_->workers.size()) + 1; }

void ThreadPool::Run(int64_t count, Function function, void* body) {
  State& state = *state_;
  // Also for loops that the caller runs alone: it is worker 0, of whom there is one.
  const std::lock_guard run_lock(state.run_mutex);
  if (state.workers.empty() || count <= 1) {
    for (int64_t i = 0; i < count; ++i) {
      function(body, i, 0);
    }
    return;
  }
  state.count = count;
  state.function = function;
  state.body = body;
  state.next.store(0, std::memory_order_relaxed);
  state.caller_processor.store(sched_getcpu(), std::memory_order_relaxed);
  state.Publish((state.loop.load() / kNumber + 1) * kNumber | kOpen);
  state.Drain(0);
  state.Close();
}

}  // namespace gluevo::nn
