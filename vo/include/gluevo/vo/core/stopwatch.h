#pragma once

#include <chrono>
#include <map>
#include <string>

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

/// Adds the time of stages that take turns to a table of milliseconds.
class StageTimer {
 public:
  /// Keeps a reference.
  explicit StageTimer(std::map<std::string, double>& stages_ms) : stages_ms_(stages_ms) {}
  /// What was done since the last end was this stage.
  void End(const std::string& stage) { stages_ms_[stage] += watch_.Lap(); }

 private:
  std::map<std::string, double>& stages_ms_;
  Stopwatch watch_;
};

}  // namespace gluevo::vo
