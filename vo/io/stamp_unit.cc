#include "stamp_unit.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <sstream>

#include "gluevo/vo/core/steps.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

constexpr StampUnit kUnits[] = {9, 6, 3, 0};

int64_t PowerOfTen(int exponent) {
  int64_t power = 1;
  for (int i = 0; i < exponent; ++i) {
    power *= 10;
  }
  return power;
}

// 0, 33, 67, 100: a clock, rounded. Every third of numbered images would have equal steps, and a
// choice among them unequal ones.
bool NearlyEqual(const std::vector<int64_t>& steps, int64_t median) {
  constexpr std::size_t kFewest = 4;
  constexpr int64_t kShortest = 10;
  int64_t divisor = 0;
  for (const int64_t step : steps) {
    divisor = std::gcd(divisor, step);
  }
  if (steps.size() < kFewest || median < kShortest || divisor >= kShortest) {
    return false;
  }
  const int64_t tolerance = std::max<int64_t>(1, median / 10);
  const auto near = std::count_if(steps.begin(), steps.end(), [&](int64_t step) {
    return std::abs(step - median) <= tolerance;
  });
  return 5 * near >= 4 * static_cast<std::ptrdiff_t>(steps.size());
}

// "Z", "+02:00", "-0800" or "+02" behind a time of day: how far its clock is ahead of UTC.
std::optional<std::chrono::minutes> TakeOffset(std::string& text) {
  const std::size_t clock = std::min(text.find(':'), text.size());
  if (text.ends_with('Z') || text.ends_with('z')) {
    text.pop_back();
    return std::chrono::minutes(0);
  }
  const std::size_t sign = text.find_first_of("+-", clock);
  if (sign == std::string::npos) {
    return std::chrono::minutes(0);
  }
  std::string digits = text.substr(sign + 1);
  std::erase(digits, ':');
  digits += digits.size() == 2 ? "00" : "";
  const std::optional<int64_t> offset = digits.size() == 4 ? ParseInteger(digits) : std::nullopt;
  if (!offset || *offset < 0) {
    return std::nullopt;
  }
  const std::chrono::minutes minutes(*offset / 100 * 60 + *offset % 100);
  const bool behind = text[sign] == '-';
  text.resize(sign);
  return behind ? -minutes : minutes;
}

}  // namespace

std::string UnitName(StampUnit unit) {
  return unit == 9   ? "nanoseconds"
         : unit == 6 ? "microseconds"
         : unit == 3 ? "milliseconds"
                     : "seconds";
}

std::string TimeText(int64_t duration_ns) {
  constexpr const char* kNames[] = {" ns", " us", " ms", " s"};
  auto value = static_cast<double>(duration_ns);
  int name = 0;
  for (; std::abs(value) >= 1000.0 && name < 3; ++name) {
    value /= 1000.0;
  }
  std::ostringstream text;
  text.precision(4);
  text << value << kNames[name];
  return text.str();
}

std::optional<StampUnit> UnitSince1970(const std::vector<int64_t>& stamps) {
  if (stamps.empty()) {
    return std::nullopt;
  }
  constexpr int64_t kFirstSecond = 900'000'000;
  constexpr int64_t kLastSecond = 4'200'000'000;
  const auto [first, last] = std::minmax_element(stamps.begin(), stamps.end());
  for (const StampUnit unit : kUnits) {
    const int64_t second = PowerOfTen(unit);
    if (*first >= kFirstSecond * second && *last <= kLastSecond * second) {
      const int64_t step = MedianStep(stamps);
      const bool plausible = step == 0 || (step >= second / 10'000 && step <= 20 * second);
      return plausible ? std::optional(unit) : std::nullopt;
    }
  }
  return std::nullopt;
}

StampUnit UnitOfStep(int64_t step) {
  return step >= 5'000'000 ? 9 : step >= 5'000 ? 6 : step >= 5 ? 3 : 0;
}

std::optional<StampUnit> UnitOfNames(const std::vector<int64_t>& numbers) {
  if (const std::optional<StampUnit> unit = UnitSince1970(numbers)) {
    return unit;
  }
  constexpr int64_t kNoNumberOfImages = 5000;
  const std::vector<int64_t> steps = StepsBetween(numbers);
  const int64_t step = MedianStep(numbers);
  if (step >= kNoNumberOfImages) {
    return UnitOfStep(step);
  }
  // 16 digits, and nothing to tell more by.
  constexpr int64_t kLarge = 1'000'000'000'000'000;
  if (steps.empty() && !numbers.empty() && numbers.front() >= kLarge) {
    return 9;
  }
  constexpr StampUnit kMilliseconds = 3;
  return NearlyEqual(steps, step) ? std::optional(kMilliseconds) : std::nullopt;
}

std::optional<int64_t> InNanoseconds(int64_t stamp, StampUnit unit) {
  const int64_t factor = PowerOfTen(9 - unit);
  if (stamp > std::numeric_limits<int64_t>::max() / factor ||
      stamp < std::numeric_limits<int64_t>::min() / factor) {
    return std::nullopt;
  }
  return stamp * factor;
}

std::optional<int64_t> DecimalInNanoseconds(std::string_view text, StampUnit unit) {
  if (unit == 0) {
    return ParseSeconds(text);
  }
  const std::size_t e = text.find_first_of("eE");
  const auto exponent =
      e == std::string_view::npos ? std::optional<int64_t>(0) : ParseInteger(text.substr(e + 1));
  if (!exponent) {
    return std::nullopt;
  }
  return ParseSeconds(std::string(text.substr(0, e)) + "e" + std::to_string(*exponent - unit));
}

StampUnit UnitOfDecimals(double largest) {
  return largest > 1e17 ? 9 : largest > 1e14 ? 6 : largest > 1e11 ? 3 : 0;
}

std::optional<int64_t> ParseDateTime(std::string_view text) {
  std::string with_blank(text);
  std::replace(with_blank.begin(), with_blank.end(), 'T', ' ');
  const std::optional<std::chrono::minutes> ahead = TakeOffset(with_blank);
  if (!ahead) {
    return std::nullopt;
  }
  const auto fields = SplitFields(with_blank, ' ');
  if (fields.size() != 2) {
    return std::nullopt;
  }
  const auto date = SplitFields(fields[0], '-');
  const auto time = SplitFields(fields[1], ':');
  if (date.size() != 3 || time.size() != 3) {
    return std::nullopt;
  }
  const auto field = [](std::string_view digits, int64_t first,
                        int64_t last) -> std::optional<int64_t> {
    const std::optional<int64_t> value = ParseInteger(digits);
    return value && *value >= first && *value <= last ? value : std::nullopt;
  };
  const auto year = field(date[0], 1900, 2200);
  const auto month = field(date[1], 1, 12);
  const auto day = field(date[2], 1, 31);
  const auto hour = field(time[0], 0, 23);
  const auto minute = field(time[1], 0, 59);
  const auto second_ns = ParseSeconds(time[2]);
  constexpr int64_t kLeapMinuteNs = 61'000'000'000;
  if (!year || !month || !day || !hour || !minute || !second_ns || *second_ns < 0 ||
      *second_ns >= kLeapMinuteNs) {
    return std::nullopt;
  }
  const std::chrono::year_month_day calendar_day(std::chrono::year(static_cast<int>(*year)),
                                                 std::chrono::month(static_cast<unsigned>(*month)),
                                                 std::chrono::day(static_cast<unsigned>(*day)));
  if (!calendar_day.ok()) {
    return std::nullopt;
  }
  const std::chrono::seconds seconds = std::chrono::sys_days(calendar_day).time_since_epoch() +
                                       std::chrono::hours(*hour) + std::chrono::minutes(*minute) -
                                       *ahead;
  return std::chrono::nanoseconds(seconds).count() + *second_ns;
}

}  // namespace gluevo::vo
