#include "gluevo/nn/thread_pool.h"

#include <sched.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace gluevo::nn {
namespace {

// A layer of a network follows the one before within microseconds, so a worker that spins this
// many times (some 50 us) before it sleeps is there when the next loop starts.
constexpr int kSpins = 2000;

void Pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

int AvailableProcessors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) == 0 && CPU_COUNT(&set) > 0) {
    return CPU_COUNT(&set);
  }
  return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

}  // namespace

struct ThreadPool::State {
  struct Loop {
    int64_t count = 0;
    Function function = nullptr;
    void* body = nullptr;
  };

  std::mutex run_mutex;  // One loop at a time.

  std::mutex mutex;
  std::condition_variable wake;
  std::atomic<uint64_t> generation = 0;  // Changes when a loop starts or the pool stops.
  bool stop = false;
  Loop loop;
  std::atomic<int64_t> next = 0;
  std::atomic<int> busy = 0;  // Workers that have not yet left the current loop.

  std::vector<std::thread> workers;

  void Drain(int worker) {
    for (int64_t i = next.fetch_add(1, std::memory_order_relaxed); i < loop.count;
         i = next.fetch_add(1, std::memory_order_relaxed)) {
      loop.function(loop.body, i, worker);
    }
  }

  void Work(int worker) {
    uint64_t seen = 0;
    while (true) {
      for (int spin = 0; spin < kSpins && generation.load(std::memory_order_acquire) == seen;
           ++spin) {
        Pause();
      }
      if (generation.load(std::memory_order_acquire) == seen) {
        std::unique_lock lock(mutex);
        wake.wait(lock, [&] { return generation.load(std::memory_order_acquire) != seen; });
      }
      seen = generation.load(std::memory_order_acquire);
      if (stop) {
        return;
      }
      Drain(worker);
      busy.fetch_sub(1, std::memory_order_release);
    }
  }
};

ThreadPool::ThreadPool(int threads) : state_(std::make_unique<State>()) {
  const int count = threads > 0 ? threads : AvailableProcessors();
  for (int worker = 1; worker < count; ++worker) {
    state_->workers.emplace_back([state = state_.get(), worker] { state->Work(worker); });
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stop = true;
    state_->generation.fetch_add(1, std::memory_order_release);
  }
  state_->wake.notify_all();
  for (std::thread& worker : state_->workers) {
    worker.join();
  }
}

int ThreadPool::size() const { return static_cast<int>(state_->workers.size()) + 1; }

void ThreadPool::Run(int64_t count, Function function, void* body) {
  if (state_->workers.empty() || count <= 1) {
    for (int64_t i = 0; i < count; ++i) {
      function(body, i, 0);
    }
    return;
  }
  const std::lock_guard run_lock(state_->run_mutex);
  state_->loop = {count, function, body};
  state_->next.store(0, std::memory_order_relaxed);
  state_->busy.store(static_cast<int>(state_->workers.size()), std::memory_order_relaxed);
  {
    const std::lock_guard lock(state_->mutex);
    state_->generation.fetch_add(1, std::memory_order_release);
  }
  state_->wake.notify_all();
  state_->Drain(0);
  // A worker that the system has preempted inside its last index may take a time slice.
  for (int spin = 0; state_->busy.load(std::memory_order_acquire) != 0; ++spin) {
    if (spin < kSpins) {
      Pause();
    } else {
      std::this_thread::yield();
    }
  }
}

}  // namespace gluevo::nn
