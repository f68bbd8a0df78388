#include "name_dates.h"

#include <algorithm>
#include <string>

#include "gluevo/vo/core/steps.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

// A run of digits in a name, and what stands between it and the one before.
struct Run {
  std::string digits;
  std::string before;
};
using Runs = std::vector<Run>;

Runs RunsOf(const NameParts& name) {
  Runs runs;
  std::string before;
  std::size_t number = 0;
  for (const char c : name.skeleton) {
    if (c != '#') {
      before.push_back(c);
      continue;
    }
    const std::string& text = name.numbers[number++];
    const std::size_t point = text.find('.');
    runs.push_back({text.substr(0, point), before});
    if (point != std::string::npos) {
      runs.push_back({text.substr(point + 1), "."});
    }
    before.clear();
  }
  return runs;
}

struct Date {
  std::string second;    // "2023-05-01 12:00:58".
  std::string fraction;  // Digits behind it.
  bool apart = false;    // The fraction is a number of its own, and no point is before it.
};

// Takes so many digits, which lie in one run or fill the rest of one each.
std::optional<std::string> Take(const Runs& runs, std::size_t& at, std::size_t& offset,
                                const std::vector<std::size_t>& lengths) {
  std::string digits;
  for (const std::size_t length : lengths) {
    if (at >= runs.size() || offset + length > runs[at].digits.size()) {
      return std::nullopt;
    }
    digits += runs[at].digits.substr(offset, length);
    offset += length;
    if (offset == runs[at].digits.size()) {
      offset = 0;
      ++at;
    }
  }
  return digits;
}

std::optional<Date> DateFrom(const Runs& runs, std::size_t at) {
  std::size_t offset = 0;
  const std::optional<std::string> day = Take(runs, at, offset, {4, 2, 2});
  const std::optional<std::string> time = day ? Take(runs, at, offset, {2, 2, 2}) : std::nullopt;
  if (!time || day->substr(0, 4) < "1990" || day->substr(0, 4) > "2100") {
    return std::nullopt;
  }
  Date date;
  date.second = day->substr(0, 4) + '-' + day->substr(4, 2) + '-' + day->substr(6) + ' ' +
                time->substr(0, 2) + ':' + time->substr(2, 2) + ':' + time->substr(4);
  if (offset > 0) {
    date.fraction = runs[at].digits.substr(offset);
  } else if (at < runs.size() && runs[at].before.size() == 1 &&
             std::string("._-,:").find(runs[at].before) != std::string::npos) {
    date.fraction = runs[at].digits;
    date.apart = runs[at].before != ".";
  }
  constexpr std::size_t kDecimals = 9;
  const bool valid = ParseDateTime(date.second) && date.fraction.size() <= kDecimals;
  return valid ? std::optional(date) : std::nullopt;
}

bool NeverFalls(const std::vector<Date>& dates) {
  bool grew = false;
  for (std::size_t i = 1; i < dates.size(); ++i) {
    const auto before = ParseInteger(dates[i - 1].fraction);
    const auto now = ParseInteger(dates[i].fraction);
    if (!before || !now || *now < *before) {
      return false;
    }
    grew = grew || *now > *before;
  }
  return grew;
}

// Whether numbers behind one and the same second are parts of it and count no images: all have the
// digits of milli-, micro- or nanoseconds, and step on as images follow each other, which of
// milliseconds is further than each tenth image's number does.
bool StepAsPartsOfSeconds(const std::vector<Date>& dates) {
  constexpr std::size_t kDecimals = 9;
  const std::size_t digits = dates.front().fraction.size();
  std::vector<int64_t> parts_ns;
  parts_ns.reserve(dates.size());
  for (const Date& date : dates) {
    const std::string zeros(kDecimals - date.fraction.size(), '0');
    parts_ns.push_back(ParseInteger(date.fraction + zeros).value_or(0));
    if (date.fraction.size() != digits || digits == 0 || digits % 3 != 0) {
      return false;
    }
  }
  constexpr int64_t kMillisecondNs = 1'000'000;
  return MedianStep(parts_ns) > (digits == 3 ? 10 : 1) * kMillisecondNs;
}

std::optional<NameNumbers> TimesOf(const std::vector<Date>& dates) {
  std::size_t most = 0;
  bool apart = false;
  bool same_digits = true;
  bool same_second = true;
  for (const Date& date : dates) {
    most = std::max(most, date.fraction.size());
    apart = apart || date.apart;
    same_digits = same_digits && date.fraction.size() == dates.front().fraction.size();
    same_second = same_second && date.second == dates.front().second;
  }
  // What goes on counting from second to second, or within one as images do, is no part of it.
  if (apart && (same_second ? !StepAsPartsOfSeconds(dates) : NeverFalls(dates))) {
    return std::nullopt;
  }
  // Numbers of their own may be written without the zeros before them.
  const std::size_t digits = !apart || same_digits ? 0 : most > 6 ? 9 : most > 3 ? 6 : 3;
  NameNumbers numbers;
  numbers.unit = 9;
  numbers.in_nanoseconds = true;
  numbers.form = "years, months, days, hours, minutes and seconds";
  for (const Date& date : dates) {
    const std::size_t zeros = std::max(digits, date.fraction.size()) - date.fraction.size();
    const std::string decimals = std::string(zeros, '0') + date.fraction;
    numbers.values.push_back(
        ParseDateTime(date.second + (decimals.empty() ? "" : "." + decimals)).value_or(0));
  }
  return numbers;
}

}  // namespace

std::optional<NameNumbers> DatesOf(const std::vector<NameParts>& parts) {
  std::vector<Runs> names;
  names.reserve(parts.size());
  for (const NameParts& name : parts) {
    names.push_back(RunsOf(name));
  }
  for (std::size_t at = 0; at < names.front().size(); ++at) {
    std::vector<Date> dates;
    for (const Runs& runs : names) {
      const std::optional<Date> date = DateFrom(runs, at);
      if (!date) {
        break;
      }
      dates.push_back(*date);
    }
    if (dates.size() == names.size()) {
      return TimesOf(dates);
    }
  }
  return std::nullopt;
}

}  // namespace gluevo::vo
