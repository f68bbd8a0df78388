#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace gluevo::simulation {

/// The number of threads that an option of 0 ("all") stands for.
inline int ThreadCount(int requested) {
  return requested > 0 ? requested : std::max(1U, std::thread::hardware_concurrency());
}

/// Calls body(i) for i = 0 .. count - 1, each once, on up to `threads` threads, in no fixed order.
/// The first exception ends the work and is thrown here.
template <typename Body>
void ParallelFor(int count, int threads, const Body& body) {
  std::atomic<int> next = 0;
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(failure_mutex);
        failure = failure ? failure : std::current_exception();
        next = count;
      }
    }
  };
  {
    std::vector<std::jthread> workers;
    for (int i = 1; i < std::min(threads, count); ++i) workers.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace gluevo::simulation
