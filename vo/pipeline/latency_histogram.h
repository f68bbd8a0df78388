#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace gluevo::vo::internal {

/// Counts times in bins that are one per cent wide, from 10 microseconds to over an hour: its
/// memory does not grow.
class LatencyHistogram {
 public:
  void Add(double ms) {
    const double step = std::log(std::max(ms, kLeastMs) / kLeastMs) / std::log(kWidth);
    ++counts_[std::min(counts_.size() - 1, static_cast<std::size_t>(step))];
    ++count_;
    max_ms_ = std::max(max_ms_, ms);
  }
  /// The time that a share `q` of them stays below, to one per cent; 0 of none.
  double Quantile(double q) const {
    auto left = static_cast<int64_t>(std::ceil(q * static_cast<double>(count_)));
    for (std::size_t i = 0; i < counts_.size() && count_ > 0; ++i) {
      left -= counts_[i];
      if (left <= 0) {
        return std::min(max_ms_, kLeastMs * std::pow(kWidth, static_cast<double>(i) + 0.5));
      }
    }
    return max_ms_;
  }
  double max_ms() const { return max_ms_; }

 private:
  static constexpr double kLeastMs = 0.01;
  static constexpr double kWidth = 1.01;

  std::array<int64_t, 2000> counts_ = {};
  int64_t count_ = 0;
  double max_ms_ = 0.0;
};

}  // namespace gluevo::vo::internal
