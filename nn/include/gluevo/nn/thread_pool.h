#pragma once

#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>

namespace gluevo::nn {

/// Persistent threads that share loops. Which thread runs which index is not defined, so what a
/// loop body computes must depend on its index only; then results are the same for any number of
/// threads.
///
/// Indices are handed out one at a time in ascending order: when a call with some index begins, all
/// lower ones have been handed to threads that are running them or have done so. So a body may wait
/// until another index is done, if that one is lower: the lowest index at work waits for nobody,
/// and every loop ends, whatever the number of threads and however late some of them come.
class ThreadPool {
 public:
  /// `threads` counts the calling thread; 0 means one for each processor this process may use.
  explicit ThreadPool(int threads = 0);
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool();

  int size() const;

  /// Calls body(index, worker) for each index in [0, count), and returns when all are done.
  /// worker < size() is the same for no two calls that run at once. The body must not throw, and
  /// must not call the pool again. One loop at a time: calls from several threads wait in turn.
  template <typename Body>
  void ParallelFor(int64_t count, Body&& body) {
    Run(count, &Call<std::remove_reference_t<Body>>, &body);
  }

 private:
  using Function = void (*)(void* body, int64_t index, int worker);
  template <typename Body>
  static void Call(void* body, int64_t index, int worker) {
    (*static_cast<Body*>(body))(index, worker);
  }
  void Run(int64_t count, Function function, void* body);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gluevo::nn
