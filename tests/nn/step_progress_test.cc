#include "step_progress.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "gluevo/nn/thread_pool.h"

namespace gluevo::nn {
namespace {

// Each band of a step reads what the bands that it waits for wrote in the step before.
TEST(StepProgressTest, WhatWasWaitedForIsThere) {
  constexpr std::array<int64_t, 2> kBands = {3, 2};
  constexpr int64_t kAll = 5;
  constexpr int64_t kSteps = 300;
  for (const int threads : {1, 2, 3}) {
    ThreadPool pool(threads);
    std::vector<int32_t> counts(2 * kSteps, 7);
    std::vector<int32_t> passed(kAll, 7);
    StepProgress progress(counts.data(), passed.data(), kBands, kSteps);
    std::vector<int64_t> written(kSteps * kAll, -1);
    std::vector<int> missed(pool.size(), 0);
    pool.ParallelFor(kSteps * kAll, [&](int64_t task, int worker) {
      const int64_t step = task / kAll;
      const int64_t band = task % kAll;
      const int image = band < kBands[0] ? 0 : 1;
      if (step > 0) {
        const int64_t* const before = &written[(step - 1) * kAll];
        progress.WaitForBand(step - 1, band);
        missed[worker] += before[band] == step - 1 ? 0 : 1;
        const int other = 1 - image;
        progress.WaitForImage(step - 1, other);
        for (int64_t i = other * kBands[0]; i < (other == 0 ? kBands[0] : kAll); ++i) {
          missed[worker] += before[i] == step - 1 ? 0 : 1;
        }
      }
      written[task] = step;
      progress.Pass(step, image, band);
    });
    for (const int count : missed) {
      EXPECT_EQ(count, 0) << threads << " threads";
    }
  }
}

}  // namespace
}  // namespace gluevo::nn
