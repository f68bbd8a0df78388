#include "text_file.h"

#include <charconv>
#include <cmath>
#include <fstream>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) {
    text.remove_prefix(1);
  }
  while (!text.empty() && IsBlank(text.back())) {
    text.remove_suffix(1);
  }
  return text;
}

std::string_view WithoutPlus(std::string_view text) {
  return text.starts_with('+') ? text.substr(1) : text;
}

}  // namespace

std::vector<TextLine> ReadLines(const std::filesystem::path& path, bool skip_comments) {
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path)) {
    throw Error(path.string() + ": cannot be read");
  }
  std::vector<TextLine> lines;
  std::string text;
  for (int number = 1; std::getline(file, text); ++number) {
    const std::string_view trimmed = Trimmed(text);
    if (!skip_comments || (!trimmed.empty() && trimmed.front() != '#')) {
      lines.push_back({number, std::string(trimmed)});
    }
  }
  if (file.bad()) {
    throw Error(path.string() + ": reading failed");
  }
  return lines;
}

std::string At(const std::filesystem::path& path, const TextLine& line) {
  return path.string() + ":" + std::to_string(line.number);
}

std::vector<std::string_view> SplitFields(std::string_view text, char separator) {
  std::vector<std::string_view> fields;
  if (separator == ' ') {
    std::size_t i = 0;
    while (i < text.size()) {
      while (i < text.size() && IsBlank(text[i])) {
        ++i;
      }
      const std::size_t begin = i;
      while (i < text.size() && !IsBlank(text[i])) {
        ++i;
      }
      if (i > begin) {
        fields.push_back(text.substr(begin, i - begin));
      }
    }
    return fields;
  }
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = text.find(separator, begin);
    fields.push_back(Trimmed(text.substr(begin, end - begin)));
    if (end == std::string_view::npos) {
      return fields;
    }
    begin = end + 1;
  }
}

std::optional<double> ParseNumber(std::string_view text) {
  text = WithoutPlus(text);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::optional<int64_t> ParseInteger(std::string_view text) {
  text = WithoutPlus(text);
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    return std::nullopt;
  }
  return value;
}

std::optional<int64_t> ParseSeconds(std::string_view text) {
  const bool negative = text.starts_with('-');
  text = negative ? text.substr(1) : WithoutPlus(text);

  int exponent = 0;
  if (const std::size_t e = text.find_first_of("eE"); e != std::string_view::npos) {
    const auto value = ParseInteger(text.substr(e + 1));
    if (!value || std::abs(*value) > 30) {
      return std::nullopt;
    }
    exponent = static_cast<int>(*value);
    text = text.substr(0, e);
  }
  std::string digits;
  int after_point = 0;
  bool seen_point = false;
  for (const char c : text) {
    if (c == '.' && !seen_point) {
      seen_point = true;
    } else if (IsDigit(c)) {
      digits += c;
      after_point += seen_point ? 1 : 0;
    } else {
      return std::nullopt;
    }
  }
  if (digits.empty()) {
    return std::nullopt;
  }
  // The value is digits * 10^shift nanoseconds.
  const int shift = exponent - after_point + 9;
  digits.insert(0, "0");
  bool round_up = false;
  if (shift >= 0) {
    digits.append(static_cast<std::size_t>(shift), '0');
  } else if (static_cast<std::size_t>(-shift) >= digits.size()) {
    digits = "0";
  } else {
    round_up = digits[digits.size() - static_cast<std::size_t>(-shift)] >= '5';
    digits.resize(digits.size() - static_cast<std::size_t>(-shift));
  }
  const auto nanoseconds = ParseInteger(digits);
  if (!nanoseconds) {
    return std::nullopt;
  }
  const int64_t rounded = *nanoseconds + (round_up ? 1 : 0);
  return negative ? -rounded : rounded;
}

}  // namespace gluevo::vo
