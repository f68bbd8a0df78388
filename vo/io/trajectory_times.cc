#include "trajectory_times.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/steps.h"
#include "gluevo/vo/core/text.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

constexpr TimeUnit kUnits[] = {TimeUnit::kSeconds, TimeUnit::kMilliseconds, TimeUnit::kMicroseconds,
                               TimeUnit::kNanoseconds};

double Seconds(double value, TimeUnit unit) {
  return value * std::pow(10.0, static_cast<double>(static_cast<int>(unit)) - 9.0);
}

// Times from 2001 on have 13 digits as milliseconds, 16 as microseconds, 19 as nanoseconds; no
// clock that begins with a recording reaches them (10^11 ms are three years).
std::optional<TimeUnit> UnitByDigits(double largest) {
  constexpr double kNanoseconds = 1e17;
  constexpr double kMicroseconds = 1e14;
  constexpr double kMilliseconds = 1e11;
  if (largest >= kNanoseconds) {
    return TimeUnit::kNanoseconds;
  }
  if (largest >= kMicroseconds) {
    return TimeUnit::kMicroseconds;
  }
  return largest >= kMilliseconds ? std::optional(TimeUnit::kMilliseconds) : std::nullopt;
}

constexpr int64_t kMillisecondNs = 1'000'000;

bool IsSame(const StampedPose& a, const StampedPose& b) {
  return a.timestamp_ns == b.timestamp_ns &&
         a.world_from_body.translation == b.world_from_body.translation &&
         a.world_from_body.rotation.coeffs() == b.world_from_body.rotation.coeffs();
}

}  // namespace

std::string NameOf(TimeUnit unit) {
  switch (unit) {
    case TimeUnit::kSeconds:
      return "seconds";
    case TimeUnit::kMilliseconds:
      return "milliseconds";
    case TimeUnit::kMicroseconds:
      return "microseconds";
    case TimeUnit::kNanoseconds:
      break;
  }
  return "nanoseconds";
}

TimeUnit ChooseTimeUnit(const std::vector<std::string_view>& times, TimeUnit usual, bool is_named,
                        double typical_s) {
  std::vector<double> values;
  values.reserve(times.size());
  double largest = 0.0;
  bool fractions = false;
  for (const std::string_view time : times) {
    if (const std::optional<double> value = ParseNumber(time)) {
      values.push_back(*value);
      largest = std::max(largest, std::abs(*value));
      fractions = fractions || *value != std::floor(*value);
    }
  }
  if (const std::optional<TimeUnit> unit = UnitByDigits(largest)) {
    return *unit;
  }
  const double step = MedianStep(std::move(values));
  if (step == 0.0) {
    return fractions ? TimeUnit::kSeconds : usual;
  }
  constexpr double kLongestOfFractions = 1000.0;
  constexpr double kShortest = 1e-4;
  constexpr double kLongest = 10.0;
  const auto possible = [&](TimeUnit unit) {
    return Seconds(step, unit) >= kShortest && Seconds(step, unit) <= kLongest;
  };
  if (fractions && step <= kLongestOfFractions && !(is_named && possible(usual))) {
    return TimeUnit::kSeconds;
  }
  if (possible(usual)) {
    return usual;
  }
  std::optional<TimeUnit> best;
  const auto oddness = [&](TimeUnit unit) {
    return std::abs(std::log(Seconds(step, unit) / typical_s));
  };
  for (const TimeUnit unit : kUnits) {
    if (possible(unit) && (!best || oddness(unit) < oddness(*best))) {
      best = unit;
    }
  }
  return best.value_or(usual);
}

Trajectory InOrderOfTime(const std::filesystem::path& path, std::vector<PoseRow> rows,
                         std::vector<std::string>& notes) {
  const auto before = [](const PoseRow& a, const PoseRow& b) {
    return a.pose.timestamp_ns < b.pose.timestamp_ns;
  };
  const auto unordered = std::is_sorted_until(rows.begin(), rows.end(), before);
  if (unordered != rows.end()) {
    notes.push_back("times are not in order (first in line " + std::to_string(unordered->line) +
                    "): sorted");
    std::stable_sort(rows.begin(), rows.end(), before);
  }
  Trajectory trajectory;
  trajectory.reserve(rows.size());
  std::size_t repeated = 0;
  std::size_t equal = 0;
  bool few_digits = true;
  int first_line = 0;
  for (const PoseRow& row : rows) {
    few_digits = few_digits && row.pose.timestamp_ns % kMillisecondNs == 0;
    if (!trajectory.empty() && IsSame(row.pose, trajectory.back())) {
      ++equal;
      continue;
    }
    if (!trajectory.empty() && row.pose.timestamp_ns == trajectory.back().timestamp_ns) {
      first_line = repeated == 0 ? row.line : first_line;
      ++repeated;
      continue;
    }
    trajectory.push_back(row.pose);
  }
  // A recorder that stutters repeats some; that a tenth is the same comes from rounding.
  constexpr std::size_t kSome = 2;
  constexpr std::size_t kTenth = 10;
  if (repeated > kSome && repeated * kTenth > rows.size()) {
    throw Error(path.string() + ":" + std::to_string(first_line) + ": the same time as in a row " +
                "before, as in " + std::to_string(repeated) + " of " + std::to_string(rows.size()) +
                " rows: " +
                (few_digits ? "the times have too few digits; write them with all their decimals "
                              "(std::fixed)"
                            : "are two runs, or two trajectories, in one file?"));
  }
  if (equal > 0) {
    notes.push_back(Counted(equal, "row is", "rows are") + " in the file twice: left out once");
  }
  if (repeated > 0) {
    notes.push_back(Counted(repeated, "row repeats", "rows repeat") +
                    " the time of another (first in line " + std::to_string(first_line) +
                    "): left out");
  }
  return trajectory;
}

}  // namespace gluevo::vo
