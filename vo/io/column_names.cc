#include "column_names.h"

#include <algorithm>
#include <cctype>
#include <limits>

#include "text_file.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kSecondNs = 1'000'000'000;

Words LowerCaseWords(std::string_view text) {
  Words words;
  bool inside = false;
  for (const char c : text) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalnum(letter) == 0) {
      inside = false;
      continue;
    }
    if (!inside) {
      words.emplace_back();
    }
    words.back().push_back(static_cast<char>(std::tolower(letter)));
    inside = true;
  }
  return words;
}

std::optional<TimeUnit> UnitOf(const Words& words) {
  for (const std::string& word : words) {
    if (IsOneOf(word, {"s", "sec", "secs", "second", "seconds"})) {
      return TimeUnit::kSeconds;
    }
    if (IsOneOf(word, {"ms", "msec", "msecs", "millis", "millisecond", "milliseconds"})) {
      return TimeUnit::kMilliseconds;
    }
    if (IsOneOf(word, {"us", "usec", "usecs", "micros", "microsecond", "microseconds"})) {
      return TimeUnit::kMicroseconds;
    }
    if (IsOneOf(word, {"ns", "nsec", "nsecs", "nanos", "nanosec", "nanosecond", "nanoseconds"})) {
      return TimeUnit::kNanoseconds;
    }
  }
  return std::nullopt;
}

}  // namespace

bool IsOneOf(const std::string& word, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* other) { return word == other; });
}

std::vector<ColumnName> SplitHeader(std::string_view header) {
  while (!header.empty() && (header.front() == '#' || header.front() == '%' ||
                             header.front() == '/' || header.front() == ' ')) {
    header.remove_prefix(1);
  }
  char separator = ' ';
  for (const char candidate : {',', ';', '\t'}) {
    if (separator == ' ' && header.find(candidate) != std::string_view::npos) {
      separator = candidate;
    }
  }
  std::vector<ColumnName> names;
  for (const std::string_view field : SplitFields(header, separator)) {
    const std::size_t bracket = std::min(field.find_first_of("[("), field.size());
    const ColumnName name = {LowerCaseWords(field.substr(0, bracket)),
                             LowerCaseWords(field.substr(bracket))};
    // "timestamp [ns] x [m]" between blanks: the bracket belongs to the name before it.
    if (separator == ' ' && bracket == 0 && !names.empty()) {
      names.back().unit = name.unit;
    } else {
      names.push_back(name);
    }
  }
  return names;
}

bool IsTime(const Words& words) {
  return (words.size() == 1 && (words[0] == "t" || UnitOf(words))) ||
         std::any_of(words.begin(), words.end(), [](const std::string& word) {
           return IsOneOf(word, {"ts", "time", "times", "timestamp", "timestamps", "stamp"});
         });
}

std::optional<TimeColumn> TimeColumnOf(const std::vector<ColumnName>& names) {
  std::optional<TimeColumn> column;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const ColumnName& name = names[i];
    if (!IsTime(name.words)) {
      continue;
    }
    const std::optional<TimeUnit> unit = UnitOf(name.unit.empty() ? name.words : name.unit);
    if (!column) {
      column = {i, std::nullopt, unit};
    } else if (column->unit == TimeUnit::kSeconds && unit == TimeUnit::kNanoseconds &&
               i == column->time + 1) {
      column->nanoseconds = i;
    }
  }
  return column;
}

std::optional<int64_t> ParseTime(const TimeColumn& column,
                                 const std::vector<std::string_view>& fields, TimeUnit unit) {
  if (std::max(column.time, column.nanoseconds.value_or(0)) >= fields.size()) {
    return std::nullopt;
  }
  const std::optional<int64_t> time = ParseShifted(fields[column.time], static_cast<int>(unit));
  if (!column.nanoseconds) {
    return time;
  }
  const std::optional<int64_t> rest = ParseInteger(fields[*column.nanoseconds]);
  const bool valid = time && rest && *rest >= 0 && *rest < kSecondNs &&
                     *time <= std::numeric_limits<int64_t>::max() - *rest;
  return valid ? std::optional(*time + *rest) : std::nullopt;
}

}  // namespace gluevo::vo
