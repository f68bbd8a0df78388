#include "gluevo/nn/peak_share.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace gluevo::nn {
namespace {

TEST(PeakShareTest, IsWhatTheCallsDoOfWhatTheProcessorCould) {
  for (const Precision precision : {Precision::kFloat, Precision::kBf16}) {
    PeakShare peak(precision, 2);
    const auto sleep = [] { std::this_thread::sleep_for(std::chrono::milliseconds(10)); };
    double seconds = peak.Time(1e6, sleep);
    EXPECT_GE(seconds, 0.01);
    seconds += peak.Time(2e6, sleep);
    EXPECT_GT(peak.peak_flops(), 1e7);  // Of the slowest machine.
    EXPECT_NEAR(peak.share() * peak.peak_flops() * seconds, 3e6, 1.0);
  }
}

// The peak of one thread varies on a busy machine, though not as much.
TEST(PeakShareTest, PeaksAddUpOverThreads) {
  PeakShare one(Precision::kFloat, 1);
  PeakShare hundred(Precision::kFloat, 100);
  const auto nothing = [] {};
  for (int i = 0; i < 3; ++i) {
    one.Time(1.0, nothing);
    hundred.Time(1.0, nothing);
  }
  EXPECT_GT(hundred.peak_flops(), 5.0 * one.peak_flops());
}

}  // namespace
}  // namespace gluevo::nn
