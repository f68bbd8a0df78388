#include "times_file.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/steps.h"
#include "name_parts.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

struct Table {
  fs::path path;
  std::vector<TextLine> lines;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> header;  // Empty where there is none.
  std::size_t columns = 0;          // That each row has.
};

std::vector<std::string> Fields(const std::string& line) {
  const char separator = line.find(',') != std::string::npos   ? ','
                         : line.find(';') != std::string::npos ? ';'
                                                               : ' ';
  const auto views = SplitFields(line, separator);
  return {views.begin(), views.end()};
}

bool IsNumber(const std::string& text) { return ParseNumber(text).has_value(); }

// A date is one field, though it has a blank inside.
std::vector<std::string> FieldsOfRow(const std::string& line) {
  return ParseDateTime(line) ? std::vector<std::string>{line} : Fields(line);
}

// A date and a time of day, or the latter alone.
std::optional<int64_t> ParseDateOrClock(const std::string& text) {
  const std::optional<int64_t> date = ParseDateTime(text);
  return date ? date : ParseDateTime("1970-01-01 " + text);
}

bool IsDate(const std::string& text) { return ParseDateOrClock(text).has_value(); }

bool IsStamp(const std::string& text) { return IsNumber(text) || IsDate(text); }

Table ReadTimesTable(const fs::path& path) {
  Table table{path, ReadLines(path, /*skip_comments=*/true), {}, {}, 0};
  for (std::size_t i = 0; i < table.lines.size();) {
    std::vector<std::string> fields = FieldsOfRow(table.lines[i].text);
    if (std::none_of(fields.begin(), fields.end(), &IsStamp)) {
      if (i > 0 || !table.header.empty()) {
        throw Error(At(path, table.lines[i]) + ": " + Quoted(table.lines[i].text) +
                    " has no time, expected one a line, with or without an image's name");
      }
      table.header = std::move(fields);
      table.lines.erase(table.lines.begin());
      continue;
    }
    table.columns = i == 0 ? fields.size() : std::min(table.columns, fields.size());
    table.rows.push_back(std::move(fields));
    ++i;
  }
  if (table.rows.empty()) {
    throw Error(path.string() + ": no times in it, expected one a line");
  }
  return table;
}

bool AllRows(const Table& table, std::size_t column, bool (*is)(const std::string&)) {
  return std::all_of(table.rows.begin(), table.rows.end(),
                     [&](const auto& row) { return is(row[column]); });
}

// 0, 1, 2, ...: numbers of images, not their times.
bool CountsRows(const Table& table, std::size_t column) {
  std::optional<int64_t> before;
  for (const auto& row : table.rows) {
    const std::optional<int64_t> number = ParseInteger(row[column]);
    if (!number || (before && *number != *before + 1)) {
      return false;
    }
    before = number;
  }
  return table.rows.size() > 1;
}

// 0, 2, 4, 7: frames' numbers with gaps, where the other column is of times that nobody counts.
bool CountsWithGaps(const Table& table, std::size_t column, std::size_t other) {
  constexpr int64_t kMostFrames = 10'000'000;
  std::optional<int64_t> before;
  std::optional<double> time_before;
  std::vector<int64_t> stamps;
  bool fractions = false;
  for (const auto& row : table.rows) {
    const std::optional<int64_t> number = ParseInteger(row[column]);
    const std::optional<double> time = ParseNumber(row[other]);
    if (!number || !time || *number < 0 || *number >= kMostFrames ||
        (before && *number <= *before) || (time_before && *time <= *time_before)) {
      return false;
    }
    before = number;
    time_before = time;
    fractions = fractions || *time != std::floor(*time);
    stamps.push_back(ParseInteger(row[other]).value_or(0));
  }
  return table.rows.size() > 1 && (fractions || UnitSince1970(stamps).has_value());
}

bool Contains(const std::string& text, const char* word) {
  const NameWords words = WordsOf(text);
  return std::any_of(words.begin(), words.end(), [&](const NameWord& found) {
    return found.text.find(word) != std::string::npos;
  });
}

std::size_t StampColumn(const Table& table) {
  for (std::size_t i = 0; i < std::min(table.header.size(), table.columns); ++i) {
    if ((Contains(table.header[i], "time") || Contains(table.header[i], "stamp")) &&
        AllRows(table, i, &IsStamp)) {
      return i;
    }
  }
  std::vector<std::size_t> stamps;
  for (std::size_t i = 0; i < table.columns; ++i) {
    if (AllRows(table, i, &IsStamp)) {
      stamps.push_back(i);
    }
  }
  if (stamps.empty()) {
    throw Error(At(table.path, table.lines.front()) +
                ": no column of times, expected one a line, with or without an image's name");
  }
  const bool numbered = stamps.size() > 1 && (CountsRows(table, stamps[0]) ||
                                              CountsWithGaps(table, stamps[0], stamps[1]));
  return numbered ? stamps[1] : stamps[0];
}

std::optional<std::size_t> ImageColumn(const Table& table, std::size_t stamp_column) {
  for (std::size_t i = 0; i < table.columns; ++i) {
    const auto is_name = [](const std::string& text) { return !IsStamp(text); };
    if (i != stamp_column && AllRows(table, i, is_name)) {
      return i;
    }
  }
  if (stamp_column > 0 && (CountsRows(table, 0) || CountsWithGaps(table, 0, stamp_column))) {
    return 0;
  }
  return std::nullopt;
}

std::optional<StampUnit> UnitOfHeader(const Table& table, std::size_t column) {
  if (column >= table.header.size()) {
    return std::nullopt;
  }
  for (const NameWord& word : WordsOf(table.header[column])) {
    const std::string& text = word.text;
    for (const auto& [begin, unit] :
         {std::pair{"nano", 9}, std::pair{"micro", 6}, std::pair{"milli", 3}}) {
      if (text.starts_with(begin)) {
        return unit;
      }
    }
    if (text == "ns" || text == "nsec" || text == "nsecs") return 9;
    if (text == "us" || text == "usec" || text == "usecs") return 6;
    if (text == "ms" || text == "msec" || text == "msecs") return 3;
    if (text == "s" || text == "sec" || text == "secs" || text == "seconds") return 0;
  }
  return std::nullopt;
}

StampUnit UnitOf(const Table& table, std::size_t column) {
  if (const std::optional<StampUnit> unit = UnitOfHeader(table, column)) {
    return *unit;
  }
  std::vector<int64_t> integers;
  double largest = 0.0;
  for (const auto& row : table.rows) {
    largest = std::max(largest, std::abs(ParseNumber(row[column]).value_or(0.0)));
    if (const std::optional<int64_t> integer = ParseInteger(row[column])) {
      integers.push_back(*integer);
    }
  }
  if (integers.size() < table.rows.size()) {
    return UnitOfDecimals(largest);
  }
  return UnitSince1970(integers).value_or(UnitOfStep(MedianStep(integers)));
}

// What is likely the cause of a time that is not after the one before.
std::string WhyNotAfter(const Table& table, std::size_t column, bool is_same) {
  constexpr std::size_t kBothParts = 2;
  const bool two_integers =
      table.columns == kBothParts &&
      std::all_of(table.rows.begin(), table.rows.end(), [](const std::vector<std::string>& row) {
        return row.size() == kBothParts && ParseInteger(row[0]) && ParseInteger(row[1]);
      });
  const std::string& line = table.lines.front().text;
  if (two_integers && line.find(',') != std::string::npos && line.find(' ') == std::string::npos) {
    return ": decimal commas? Expected decimal points (1.5, not 1,5)";
  }
  const bool rounded = std::any_of(table.rows.begin(), table.rows.end(), [&](const auto& row) {
    return row[column].find_first_of("eE") != std::string::npos;
  });
  return is_same && rounded ? ": the times have too few digits; write all their decimals" : "";
}

}  // namespace

TimesFile ReadTimesFile(const fs::path& path) {
  const Table table = ReadTimesTable(path);
  const std::size_t column = StampColumn(table);
  const std::optional<std::size_t> image_column = ImageColumn(table, column);
  const bool dates = AllRows(table, column, &IsDate);
  const StampUnit unit = dates ? 0 : UnitOf(table, column);
  TimesFile times;
  times.path = path;
  times.unit = unit == 0 ? "" : UnitName(unit);
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const std::string& text = table.rows[i][column];
    const auto time = dates ? ParseDateOrClock(text) : DecimalInNanoseconds(text, unit);
    if (!time) {
      throw Error(At(path, table.lines[i]) + ": " + Quoted(text) + " is not a time");
    }
    if (!image_column && !times.rows.empty() && *time <= times.rows.back().timestamp_ns) {
      throw Error(At(path, table.lines[i]) + ": a time that is not after the one before" +
                  WhyNotAfter(table, column, *time == times.rows.back().timestamp_ns));
    }
    times.rows.push_back({*time, image_column ? table.rows[i][*image_column] : std::string()});
  }
  return times;
}

}  // namespace gluevo::vo
