#include "name_parts.h"

#include <algorithm>
#include <cctype>

#include "name_dates.h"
#include "name_seconds.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }
bool IsLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
char Lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

std::size_t EndOfDigits(const std::string& text, std::size_t begin) {
  while (begin < text.size() && IsDigit(text[begin])) {
    ++begin;
  }
  return begin;
}

std::vector<NameColumn> ColumnsOf(const std::vector<NameParts>& parts) {
  std::vector<NameColumn> columns(parts.front().numbers.size());
  for (const NameParts& name : parts) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      columns[i].push_back(name.numbers[i]);
    }
  }
  return columns;
}

bool HasPoint(const std::string& text) { return text.find('.') != std::string::npos; }

bool Varies(const NameColumn& column) {
  return std::any_of(column.begin(), column.end(),
                     [&](const std::string& text) { return text != column.front(); });
}

std::optional<NameNumbers> Decimals(const NameColumn& column) {
  NameNumbers numbers;
  double largest = 0.0;
  for (const std::string& text : column) {
    largest = std::max(largest, ParseNumber(text).value_or(0.0));
  }
  const StampUnit unit = UnitOfDecimals(largest);
  for (const std::string& text : column) {
    const std::optional<int64_t> time = DecimalInNanoseconds(text, unit);
    if (!time) {
      return std::nullopt;
    }
    numbers.values.push_back(*time);
  }
  numbers.unit = unit;
  numbers.in_nanoseconds = true;
  numbers.form = unit == 0 ? "" : UnitName(unit);
  return numbers;
}

std::optional<NameNumbers> Integers(const NameColumn& column) {
  if (std::any_of(column.begin(), column.end(), &HasPoint)) {
    std::optional<NameNumbers> unpadded = UnpaddedParts(column);
    return unpadded ? unpadded : Decimals(column);
  }
  NameNumbers numbers;
  for (const std::string& text : column) {
    const std::optional<int64_t> value = ParseInteger(text);
    if (!value) {
      return std::nullopt;
    }
    numbers.values.push_back(*value);
  }
  numbers.unit = UnitOfNames(numbers.values);
  return numbers;
}

// Where "#_#" or "#-#" stands in the skeleton: the numbers before and after it.
std::vector<std::size_t> JoinedColumns(const std::string& skeleton) {
  std::vector<std::size_t> joined;
  std::size_t column = 0;
  for (std::size_t i = 0; i < skeleton.size(); ++i) {
    if (skeleton[i] != '#') {
      continue;
    }
    if (i + 2 < skeleton.size() && (skeleton[i + 1] == '_' || skeleton[i + 1] == '-') &&
        skeleton[i + 2] == '#') {
      joined.push_back(column);
    }
    ++column;
  }
  return joined;
}

// Whether the values go up where names do. Equal ones are a matter of whoever pairs.
bool GoUpWithNames(const std::vector<NameParts>& parts, const std::vector<int64_t>& values) {
  std::vector<std::size_t> order(parts.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = i;
  }
  const auto name_before = [&](std::size_t a, std::size_t b) {
    for (std::size_t i = 0; i < parts[a].numbers.size(); ++i) {
      const std::string& first = parts[a].numbers[i];
      const std::string& second = parts[b].numbers[i];
      if (first != second) {
        return NumbersBefore(first, second);
      }
    }
    return false;
  };
  std::stable_sort(order.begin(), order.end(), name_before);
  return std::is_sorted(order.begin(), order.end(),
                        [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
}

bool AllDiffer(std::vector<int64_t> values) {
  std::sort(values.begin(), values.end());
  return std::adjacent_find(values.begin(), values.end()) == values.end();
}

}  // namespace

NameParts PartsOf(const std::string& name) {
  NameParts parts;
  for (std::size_t at = 0; at < name.size();) {
    if (!IsDigit(name[at])) {
      // '#' of the name itself must not look like a number.
      parts.skeleton += name[at] == '#' ? '?' : Lower(name[at]);
      ++at;
      continue;
    }
    std::size_t end = EndOfDigits(name, at);
    if (end + 1 < name.size() && name[end] == '.' && IsDigit(name[end + 1])) {
      end = EndOfDigits(name, end + 1);
    }
    parts.skeleton += '#';
    parts.numbers.push_back(name.substr(at, end - at));
    at = end;
  }
  return parts;
}

std::optional<NameNumbers> NumbersOf(const std::vector<NameParts>& parts) {
  if (parts.empty() || parts.front().numbers.empty()) {
    return std::nullopt;
  }
  std::optional<NameNumbers> dates = DatesOf(parts);
  if (dates && AllDiffer(dates->values) && GoUpWithNames(parts, dates->values)) {
    return dates;
  }
  const std::vector<NameColumn> columns = ColumnsOf(parts);
  for (const std::size_t column : JoinedColumns(parts.front().skeleton)) {
    std::optional<NameNumbers> stamps = SecondsAndParts(columns[column], columns[column + 1]);
    if (stamps) {
      return stamps;
    }
  }
  std::vector<const NameColumn*> varying;
  for (const NameColumn& column : columns) {
    if (Varies(column)) {
      varying.push_back(&column);
    }
  }
  if (varying.empty()) {
    return Integers(columns.back());
  }
  if (varying.size() == 1) {
    return Integers(*varying.front());
  }
  std::optional<NameNumbers> best;
  for (const NameColumn* const column : varying) {
    std::optional<NameNumbers> numbers = Integers(*column);
    if (numbers && AllDiffer(numbers->values) && GoUpWithNames(parts, numbers->values) &&
        (!best || numbers->unit || !best->unit)) {
      best = std::move(numbers);
    }
  }
  return best;
}

bool NumbersBefore(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (!IsDigit(a[i]) || !IsDigit(b[j])) {
      if (a[i] != b[j]) {
        return a[i] < b[j];
      }
      ++i;
      ++j;
      continue;
    }
    const auto number = [](const std::string& text, std::size_t& position) {
      const std::size_t begin = std::min(text.find_first_not_of('0', position), text.size());
      position = EndOfDigits(text, begin);
      return text.substr(begin, position - begin);
    };
    const std::string first = number(a, i);
    const std::string second = number(b, j);
    if (first != second) {
      return first.size() != second.size() ? first.size() < second.size() : first < second;
    }
  }
  // Equal so far: the shorter one, else ("1" and "01") any fixed order.
  return a.size() - i != b.size() - j ? a.size() - i < b.size() - j : a < b;
}

NameWords WordsOf(const std::string& name) {
  NameWords words;
  for (std::size_t at = 0; at < name.size();) {
    const bool digits = IsDigit(name[at]);
    if (!digits && !IsLetter(name[at])) {
      ++at;
      continue;
    }
    std::size_t end = at;
    NameWord word{"", at};
    while (end < name.size() && (digits ? IsDigit(name[end]) : IsLetter(name[end]))) {
      word.text += Lower(name[end]);
      ++end;
    }
    words.push_back(word);
    at = end;
  }
  return words;
}

}  // namespace gluevo::vo
