#pragma once

#include <chrono>

namespace gluevo::vo {

/// Time of stages that follow each other.
class Stopwatch {
 public:
  /// Milliseconds since the last lap, or the start.
  double Lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - lap_).count();
    lap_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point lap_ = std::chrono::steady_clock::now();
};

}  // namespace gluevo::vo
