#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// What the first line of a table calls its columns, in the ways of many tools.
namespace gluevo::vo {

using Words = std::vector<std::string>;

bool IsOneOf(const std::string& word, std::initializer_list<const char*> words);

/// "p_RS_R_x [m]": the words before the bracket, and those in it, in lower case.
struct ColumnName {
  Words words;
  Words unit;
};

/// The names of a line, which may be a comment; between commas, semicolons, tabs or blanks.
std::vector<ColumnName> SplitHeader(std::string_view header);

/// A unit of time; its value is the number of decimals that separate it from a nanosecond.
enum class TimeUnit { kNanoseconds = 0, kMicroseconds = 3, kMilliseconds = 6, kSeconds = 9 };

/// The column of a row's time, from 0.
struct TimeColumn {
  std::size_t time = 0;
  /// ROS writes a time as seconds and nanoseconds in two columns: the second one.
  std::optional<std::size_t> nanoseconds;
  std::optional<TimeUnit> unit;  ///< Where the table says it.
};

/// Whether a column's name is that of a time: "t", "timestamp", "secs".
bool IsTime(const Words& words);

/// The first column of times.
std::optional<TimeColumn> TimeColumnOf(const std::vector<ColumnName>& names);

/// The time of a row in nanoseconds; `unit` is that of the column. Nothing for what is no time, and
/// where the row has not so many fields.
std::optional<int64_t> ParseTime(const TimeColumn& column,
                                 const std::vector<std::string_view>& fields, TimeUnit unit);

}  // namespace gluevo::vo
