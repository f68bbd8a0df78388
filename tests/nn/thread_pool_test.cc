#include "gluevo/nn/thread_pool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "gluevo/nn/error.h"

namespace gluevo::nn {
namespace {

// Longer than a waiting thread spins: afterwards all workers sleep.
constexpr auto kLongerThanSpinning = std::chrono::milliseconds(3);

TEST(ThreadPoolTest, CallsEveryIndexOnce) {
  for (const int threads : {1, 2, 3, 4, 17}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.size(), threads);
    for (const int64_t count : {0, 1, 2, 7, 1000}) {
      std::vector<int> calls(static_cast<std::size_t>(count), 0);
      pool.ParallelFor(count, [&](int64_t i, int worker) {
        ++calls[static_cast<std::size_t>(i)];
        EXPECT_GE(worker, 0);
        EXPECT_LT(worker, threads);
      });
      EXPECT_EQ(calls, std::vector<int>(static_cast<std::size_t>(count), 1));
    }
  }
}

TEST(ThreadPoolTest, ZeroThreadsMeansTheProcessorsOfThisProcess) {
  EXPECT_GE(ThreadPool(0).size(), 1);
  EXPECT_LE(ThreadPool(0).size(), static_cast<int>(std::thread::hardware_concurrency()));
}

TEST(ThreadPoolTest, RefusesMoreThreadsThanItCanCount) {
  try {
    const ThreadPool pool(1000000);
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "1000000 threads are too many: expected at most 4096");
  }
}

TEST(ThreadPoolTest, AWorkerTakesPart) {
  ThreadPool pool(2);
  for (const bool asleep : {false, true}) {
    if (asleep) {
      std::this_thread::sleep_for(kLongerThanSpinning);
    }
    // Both indices are in work at once, or this never ends.
    std::atomic<int> inside = 0;
    std::array<std::atomic<int>, 2> calls_of = {};
    pool.ParallelFor(2, [&](int64_t /*i*/, int worker) {
      ++calls_of[static_cast<std::size_t>(worker)];
      ++inside;
      while (inside < 2) {
        std::this_thread::yield();
      }
    });
    EXPECT_EQ(calls_of[0], 1);
    EXPECT_EQ(calls_of[1], 1);
  }
}

// The caller has nothing left to do, spins, sleeps, and is woken.
TEST(ThreadPoolTest, WaitsForAWorkerThatIsLateInItsLastIndex) {
  ThreadPool pool(2);
  for (int repeat = 0; repeat < 20; ++repeat) {
    std::atomic<int> inside = 0;
    std::atomic<bool> worker_done = false;
    pool.ParallelFor(2, [&](int64_t /*i*/, int worker) {
      ++inside;
      while (inside < 2) {
        std::this_thread::yield();
      }
      if (worker != 0) {
        std::this_thread::sleep_for(kLongerThanSpinning);
        worker_done = true;
      }
    });
    EXPECT_TRUE(worker_done);
  }
}

// Until done(), or for so long that it will never be: returns done().
template <typename Done>
bool WaitUntil(const Done& done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) {
      return false;
    }
    std::this_thread::yield();
  }
  return true;
}

TEST(ThreadPoolTest, HandsIndicesOutInAscendingOrder) {
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    for (const bool asleep : {false, true}) {
      if (asleep) {
        std::this_thread::sleep_for(kLongerThanSpinning);
      }
      // No thread gets a second index before each has one: these are the lowest ones.
      std::atomic<int> begun = 0;
      std::atomic<int64_t> highest_of_first = -1;
      std::vector<std::vector<int64_t>> indices_of(static_cast<std::size_t>(threads));
      pool.ParallelFor(50, [&](int64_t i, int worker) {
        indices_of[static_cast<std::size_t>(worker)].push_back(i);
        if (begun < threads) {
          int64_t highest = highest_of_first;
          while (i > highest && !highest_of_first.compare_exchange_weak(highest, i)) {
          }
        }
        ++begun;
        EXPECT_TRUE(WaitUntil([&] { return begun >= threads; }));
      });
      EXPECT_EQ(highest_of_first, threads - 1) << threads;
      for (const std::vector<int64_t>& indices : indices_of) {
        EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end())) << threads;
      }
    }
  }
}

// In the worst case each waits for all before it. Handed out otherwise, some index would wait for
// one that its own thread has yet to run.
TEST(ThreadPoolTest, BodiesMayWaitForLowerIndices) {
  constexpr int64_t kCount = 200;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    std::atomic<bool> stuck = false;
    const auto wait_in_turn = [&] {
      std::vector<std::atomic<bool>> done(kCount);
      pool.ParallelFor(kCount, [&](int64_t i, int /*worker*/) {
        for (int64_t lower = 0; lower < i && !stuck; ++lower) {
          if (!WaitUntil([&] { return done[static_cast<std::size_t>(lower)] || stuck; })) {
            stuck = true;
          }
        }
        done[static_cast<std::size_t>(i)] = true;
      });
    };
    wait_in_turn();
    std::this_thread::sleep_for(kLongerThanSpinning);  // The next loop wakes its workers.
    // The pool is busy with another caller's loop each time.
    std::thread other([&] {
      for (int repeat = 0; repeat < 5; ++repeat) {
        wait_in_turn();
      }
    });
    for (int repeat = 0; repeat < 5; ++repeat) {
      wait_in_turn();
    }
    other.join();
    EXPECT_FALSE(stuck) << threads;
  }
}

TEST(ThreadPoolTest, SumsAreTheSameForAnyNumberOfThreads) {
  constexpr int64_t kCount = 1000;
  const auto sum_with = [&](int threads) {
    ThreadPool pool(threads);
    std::vector<double> parts(kCount);
    for (int round = 0; round < 20; ++round) {
      pool.ParallelFor(kCount, [&](int64_t i, int /*worker*/) {
        auto& part = parts[static_cast<std::size_t>(i)];
        part = std::sin(part + static_cast<double>(i + round));
      });
    }
    double sum = 0.0;
    for (const double part : parts) {
      sum += part;
    }
    return sum;
  };
  const double expected = sum_with(1);
  for (const int threads : {2, 3, 4}) {
    EXPECT_EQ(sum_with(threads), expected) << threads;
  }
}

TEST(ThreadPoolTest, ManyTinyLoopsSeeWhatTheOnesBeforeWrote) {
  for (const int threads : {2, 4}) {
    ThreadPool pool(threads);
    constexpr int kLoops = 5000;
    std::vector<int> values(5, 0);
    std::vector<int> previous(5, 0);
    for (int loop = 0; loop < kLoops; ++loop) {
      previous.swap(values);
      pool.ParallelFor(5, [&](int64_t i, int /*worker*/) {
        // A neighbour's value, which another thread may have written.
        values[static_cast<std::size_t>(i)] = previous[static_cast<std::size_t>((i + 1) % 5)] + 1;
      });
    }
    EXPECT_EQ(values, std::vector<int>(5, kLoops));
  }
}

TEST(ThreadPoolTest, LoopsAfterPausesOfAnyLength) {
  ThreadPool pool(3);
  int64_t sum = 0;
  for (int pause_us = 0; pause_us < 600; pause_us += 7) {
    std::this_thread::sleep_for(std::chrono::microseconds(pause_us));
    std::array<int64_t, 6> parts = {};
    pool.ParallelFor(6, [&](int64_t i, int /*worker*/) { parts[static_cast<std::size_t>(i)] = 1; });
    for (const int64_t part : parts) {
      sum += part;
    }
  }
  EXPECT_EQ(sum, 6 * 86);
}

TEST(ThreadPoolTest, IsMadeAndDestroyedWhateverItsWorkersDo) {
  for (int repeat = 0; repeat < 200; ++repeat) {
    ThreadPool pool(4);
    if (repeat % 3 == 1) {
      pool.ParallelFor(2, [](int64_t /*i*/, int /*worker*/) {});
    } else if (repeat % 3 == 2 && repeat < 30) {
      std::this_thread::sleep_for(kLongerThanSpinning);
    }
  }
}

TEST(ThreadPoolTest, CallersFromSeveralThreadsAreNeverTheSameWorkerAtOnce) {
  for (const int threads : {1, 2, 4}) {
    ThreadPool pool(threads);
    std::vector<std::atomic<int>> inside(static_cast<std::size_t>(threads));
    std::atomic<int> clashes = 0;
    std::atomic<int64_t> calls = 0;
    const auto call = [&] {
      for (int repeat = 0; repeat < 60; ++repeat) {
        for (const int64_t count : {1, 2, 5}) {
          pool.ParallelFor(count, [&](int64_t /*i*/, int worker) {
            auto& mine = inside[static_cast<std::size_t>(worker)];
            clashes += mine.fetch_add(1) != 0 ? 1 : 0;
            ++calls;
            std::this_thread::yield();  // Lets another caller come in, were it let in.
            mine.fetch_sub(1);
          });
        }
      }
    };
    std::vector<std::thread> callers;
    callers.reserve(3);
    for (int i = 0; i < 3; ++i) {
      callers.emplace_back(call);
    }
    for (std::thread& caller : callers) {
      caller.join();
    }
    EXPECT_EQ(clashes, 0) << threads;
    EXPECT_EQ(calls, 3 * 60 * (1 + 2 + 5));
  }
}

// Loops of one index take turns too: each caller is worker 0.
TEST(ThreadPoolTest, LoopsOfOneIndexWaitInTurn) {
  for (const int threads : {1, 2}) {
    ThreadPool pool(threads);
    std::atomic<int> inside = 0;
    std::atomic<int> most = 0;
    const auto call = [&] {
      pool.ParallelFor(1, [&](int64_t /*i*/, int worker) {
        EXPECT_EQ(worker, 0);
        most = std::max<int>(most, ++inside);
        std::this_thread::sleep_for(std::chrono::milliseconds(30));
        --inside;
      });
    };
    std::thread other(call);
    call();
    other.join();
    EXPECT_EQ(most, 1) << threads;
  }
}

}  // namespace
}  // namespace gluevo::nn
