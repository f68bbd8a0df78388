#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

namespace gluevo::nn {

/// Which bands of two images have passed which steps of a network. Threads take all bands of all
/// steps in one order, in which whatever a band waits for comes before it (so ThreadPool's
/// ascending order lets it wait), and wait for no more than they need: so at the end of a step
/// nobody is idle, as all but one were if every step were a loop of its own.
class StepProgress {
 public:
  /// `counts` has room for 2 * steps of them, `passed` for one a band; bands are numbered through
  /// both images. Neither may be touched otherwise while this is in use.
  StepProgress(int32_t* counts, int32_t* passed, std::array<int64_t, 2> bands, int64_t steps)
      : counts_(counts), passed_(passed), bands_(bands) {
    std::fill_n(counts_, 2 * steps, 0);
    std::fill_n(passed_, bands[0] + bands[1], 0);
  }

  /// Marks `band`, of `image`, as having passed `step`: what its thread wrote is then seen by those
  /// that have waited for it.
  void Pass(int64_t step, int image, int64_t band) {
    std::atomic_ref(passed_[band]).store(static_cast<int32_t>(step) + 1, std::memory_order_release);
    std::atomic_ref(counts_[2 * step + image]).fetch_add(1, std::memory_order_acq_rel);
  }
  /// Until the band has passed the step.
  void WaitForBand(int64_t step, int64_t band) const {
    WaitUntil(
        [&] { return std::atomic_ref(passed_[band]).load(std::memory_order_acquire) > step; });
  }
  /// Until all bands of the image have.
  void WaitForImage(int64_t step, int image) const {
    WaitUntil([&] {
      return std::atomic_ref(counts_[2 * step + image]).load(std::memory_order_acquire) ==
             bands_[image];
    });
  }

 private:
  template <typename Done>
  static void WaitUntil(const Done& done) {
    constexpr int kChecks = 200;
    while (true) {
      for (int i = 0; i < kChecks; ++i) {
        if (done()) {
          return;
        }
      }
      std::this_thread::yield();  // Perhaps to the thread that is waited for.
    }
  }

  int32_t* counts_;
  int32_t* passed_;
  std::array<int64_t, 2> bands_;
};

}  // namespace gluevo::nn
