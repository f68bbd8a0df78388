#pragma once

#include <chrono>

#include "gluevo/nn/isa.h"
#include "gluevo/nn/precision.h"

namespace gluevo::nn {

/// Times calls and tells how near they come to the most that the processor can do: the share of the
/// multiply-adds that as many threads reach on registers alone. That peak is measured before every
/// call, since shared machines change their speed from second to second.
class PeakShare {
 public:
  /// `precision`: of the products that the calls are made of.
  PeakShare(Precision precision, int threads, Isa isa = ChooseIsa())
      : precision_(precision), isa_(isa), threads_(threads) {}

  /// Seconds that the call takes, which is of so many floating-point operations.
  template <typename Call>
  double Time(double flops, const Call& call) {
    const double peak = MeasurePeak();
    const auto start = std::chrono::steady_clock::now();
    call();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    seconds_ += seconds.count();
    flops_ += flops;
    possible_flops_ += peak * seconds.count();
    return seconds.count();
  }

  /// Of all calls so far together, at least one: 0 to 1, above where an algorithm saves operations
  /// that are counted.
  double share() const { return flops_ / possible_flops_; }
  /// The mean of the peaks, all threads together, operations a second.
  double peak_flops() const { return possible_flops_ / seconds_; }

 private:
  double MeasurePeak() const;  // Of all threads.

  Precision precision_;
  Isa isa_;
  int threads_;
  double seconds_ = 0.0;
  double flops_ = 0.0;
  double possible_flops_ = 0.0;
};

}  // namespace gluevo::nn
