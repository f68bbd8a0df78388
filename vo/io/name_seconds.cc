#include "name_seconds.h"

#include <algorithm>
#include <cstdlib>

#include "gluevo/vo/core/steps.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

bool HasPoint(const std::string& text) { return text.find('.') != std::string::npos; }

// The part of steps between times that differ from the middle one by less than its fifth; nothing
// where two times are the same.
std::optional<double> Evenness(std::vector<int64_t> times) {
  std::sort(times.begin(), times.end());
  const int64_t median = MedianStep(times);
  std::size_t even = 0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const int64_t step = times[i] - times[i - 1];
    if (step == 0) {
      return std::nullopt;
    }
    even += std::abs(step - median) < median / 5 + 1 ? 1U : 0U;
  }
  return times.size() < 2 ? 0.0 : static_cast<double>(even) / static_cast<double>(times.size() - 1);
}

}  // namespace

std::optional<NameNumbers> SecondsAndParts(const NameColumn& seconds, const NameColumn& parts) {
  constexpr std::size_t kFewestDigitsSince1970 = 9;
  constexpr std::size_t kMostDigits = 10;
  constexpr std::size_t kDigitsOfNanoseconds = 9;
  std::size_t most = 0;
  bool padded = true;
  bool since_1970 = true;
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    const bool leading_zero = seconds[i].size() > 1 && seconds[i].front() == '0';
    if (leading_zero || seconds[i].size() > kMostDigits || HasPoint(seconds[i]) ||
        HasPoint(parts[i]) || parts[i].size() > kDigitsOfNanoseconds) {
      return std::nullopt;
    }
    since_1970 = since_1970 && seconds[i].size() >= kFewestDigitsSince1970;
    padded = padded && parts[i].size() == kDigitsOfNanoseconds;
    most = std::max(most, parts[i].size());
  }
  if (!since_1970 && !padded) {
    return std::nullopt;
  }
  NameNumbers numbers;
  const StampUnit unit = most > 6 ? 9 : most > 3 ? 6 : 3;
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    const auto whole = ParseInteger(seconds[i]);
    const auto part = ParseInteger(parts[i]);
    const auto whole_ns = InNanoseconds(whole.value_or(0), 0);
    const auto part_ns = InNanoseconds(part.value_or(0), unit);
    if (!whole || !part || !whole_ns || !part_ns) {
      return std::nullopt;
    }
    numbers.values.push_back(*whole_ns + *part_ns);
  }
  constexpr int64_t kShortestStepNs = 100'000;
  const int64_t step = MedianStep(numbers.values);
  if (step != 0 && step < kShortestStepNs) {
    return std::nullopt;
  }
  numbers.unit = 9;
  numbers.in_nanoseconds = true;
  numbers.form = "seconds and " + UnitName(unit);
  return numbers;
}

std::optional<NameNumbers> UnpaddedParts(const NameColumn& column) {
  NameColumn seconds;
  NameColumn parts;
  std::vector<int64_t> decimals;
  bool same_digits = true;
  for (const std::string& text : column) {
    const std::size_t point = text.find('.');
    const std::optional<int64_t> decimal = ParseSeconds(text);
    if (point == std::string::npos || !decimal) {
      return std::nullopt;
    }
    seconds.push_back(text.substr(0, point));
    parts.push_back(text.substr(point + 1));
    decimals.push_back(*decimal);
    if (parts.back().size() > 1 && parts.back().front() == '0') {
      return std::nullopt;
    }
    same_digits = same_digits && parts.back().size() == parts.front().size();
  }
  if (same_digits) {
    return std::nullopt;
  }
  std::optional<NameNumbers> unpadded = SecondsAndParts(seconds, parts);
  const std::optional<double> evenness = unpadded ? Evenness(unpadded->values) : std::nullopt;
  const std::optional<double> evenness_of_decimals = Evenness(std::move(decimals));
  const bool better = evenness && (!evenness_of_decimals || *evenness > *evenness_of_decimals);
  return better ? unpadded : std::nullopt;
}

}  // namespace gluevo::vo
