#pragma once

#include <cstdint>
#include <map>

namespace gluevo::vo::internal {

/// The median of small whole numbers, whose memory grows with how many different ones there are.
class CountMedian {
 public:
  void Add(int value) {
    ++times_[value];
    ++count_;
  }
  /// As Median() has it: the upper one of two in the middle, 0 of none.
  int Median() const {
    int64_t before = 0;
    for (const auto& [value, times] : times_) {
      before += times;
      if (before > count_ / 2) {
        return value;
      }
    }
    return 0;
  }

 private:
  std::map<int, int64_t> times_;
  int64_t count_ = 0;
};

}  // namespace gluevo::vo::internal
