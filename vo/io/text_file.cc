#include "text_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/whole_file.h"

namespace gluevo::vo {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

std::string_view Trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

/// from_chars knows no plus sign.
std::string_view WithoutPlus(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && (IsDigit(text[1]) || text[1] == '.');
  return plus ? text.substr(1) : text;
}

/// A decimal number as 0.DIGITS times ten to the power of `point`, the first digit not being zero.
struct Decimal {
  bool negative = false;
  std::string digits;
  int64_t point = 0;
};

std::optional<Decimal> ParseDecimal(std::string_view text) {
  Decimal decimal;
  decimal.negative = text.starts_with('-');
  text = decimal.negative ? text.substr(1) : WithoutPlus(text);
  if (const std::size_t e = text.find_first_of("eE"); e != std::string_view::npos) {
    const std::optional<int64_t> exponent = ParseInteger(text.substr(e + 1));
    constexpr int64_t kLargestExponent = 1'000'000;
    if (!exponent || *exponent > kLargestExponent || *exponent < -kLargestExponent) {
      return std::nullopt;
    }
    decimal.point = *exponent;
    text = text.substr(0, e);
  }
  bool any_digit = false;
  bool after_point = false;
  for (const char c : text) {
    if (c == '.' && !after_point) {
      after_point = true;
      continue;
    }
    if (!IsDigit(c)) {
      return std::nullopt;
    }
    any_digit = true;
    const bool leading_zero = c == '0' && decimal.digits.empty();
    if (!leading_zero) {
      decimal.digits.push_back(c);
    }
    if (!after_point && !leading_zero) {
      ++decimal.point;
    } else if (after_point && leading_zero) {
      --decimal.point;
    }
  }
  return any_digit ? std::optional(decimal) : std::nullopt;
}

void CheckEncoding(std::string_view text, const std::filesystem::path& path) {
  const auto zero = [&](std::size_t i) { return i < text.size() && text[i] == '\0'; };
  const bool two_bytes = (zero(0) && zero(2)) || (zero(1) && zero(3));
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") || two_bytes) {
    throw Error(path.string() + ": text in UTF-16, expected UTF-8: save it as UTF-8");
  }
  if (text.find('\0') != std::string_view::npos) {
    throw Error(path.string() + ": not a text file: it holds zero bytes");
  }
}

}  // namespace

std::string ReadText(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw Error(path.string() + ": " + WhyNoFile(path));
  }
  return ReadWholeFile(path);
}

bool IsComment(std::string_view line) {
  return line.starts_with('#') || line.starts_with('%') || line.starts_with("//");
}

std::vector<TextLine> SplitLines(std::string_view text, const std::filesystem::path& path,
                                 bool skip_comments) {
  CheckEncoding(text, path);
  std::string_view rest = text;
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (rest.starts_with(kByteOrderMark)) {
    rest.remove_prefix(kByteOrderMark.size());
  }
  std::vector<TextLine> lines;
  for (int number = 1; !rest.empty(); ++number) {
    const std::size_t end = std::min(rest.find_first_of("\r\n"), rest.size());
    const std::string_view line = Trimmed(rest.substr(0, end));
    if (!skip_comments || (!line.empty() && !IsComment(line))) {
      lines.push_back({number, std::string(line)});
    }
    rest.remove_prefix(end);
    rest.remove_prefix(rest.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, rest.size()));
  }
  while (!lines.empty() && lines.back().text.empty()) {
    lines.pop_back();
  }
  return lines;
}

std::vector<TextLine> ReadLines(const std::filesystem::path& path, bool skip_comments) {
  return SplitLines(ReadText(path), path, skip_comments);
}

bool IsHeader(std::string_view line) {
  std::string blanks(line);
  std::replace_if(
      blanks.begin(), blanks.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
  const auto fields = SplitFields(blanks, ' ');
  return std::none_of(fields.begin(), fields.end(),
                      [](std::string_view field) { return ParseNumber(field).has_value(); });
}

std::vector<TextLine> ReadTable(const std::filesystem::path& path) {
  std::vector<TextLine> lines = ReadLines(path, /*skip_comments=*/true);
  const auto first = std::find_if(lines.begin(), lines.end(),
                                  [](const TextLine& line) { return !IsHeader(line.text); });
  // A table without any number keeps its lines, so that a message can name one.
  if (first != lines.end()) {
    lines.erase(lines.begin(), first);
  }
  return lines;
}

std::string At(const std::filesystem::path& path, const TextLine& line) {
  return path.string() + ":" + std::to_string(line.number);
}

char SeparatorOf(const std::filesystem::path& path, const TextLine& line) {
  const std::string_view text = line.text;
  const bool semicolon = text.find(';') != std::string_view::npos;
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) {
    return semicolon ? ';' : ' ';
  }
  // Between commas that separate stands one number each: "1,5 2,3" and "1,5;2,3" have more.
  const auto fields = SplitFields(text, ',');
  const bool decimal_commas =
      semicolon || std::any_of(fields.begin(), fields.end(), [](std::string_view field) {
        const auto numbers = SplitFields(field, ' ');
        return numbers.size() > 1 && ParseNumber(numbers[0]) && ParseNumber(numbers[1]);
      });
  if (decimal_commas) {
    throw Error(At(path, line) + ": decimal commas, expected decimal points (1.5, not 1,5)");
  }
  return ',';
}

std::vector<std::string_view> SplitFields(std::string_view text, char separator) {
  std::vector<std::string_view> fields;
  if (separator == ' ') {
    for (text = Trimmed(text); !text.empty(); text = Trimmed(text)) {
      const std::size_t end = std::min(text.find_first_of(kBlanks), text.size());
      fields.push_back(text.substr(0, end));
      text.remove_prefix(end);
    }
    return fields;
  }
  while (true) {
    const std::size_t end = text.find(separator);
    fields.push_back(Trimmed(text.substr(0, end)));
    if (end == std::string_view::npos) {
      return fields;
    }
    text.remove_prefix(end + 1);
  }
}

std::optional<double> ParseNumber(std::string_view text) {
  text = WithoutPlus(text);
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [parsed, error] = std::from_chars(text.data(), end, value);
  if (parsed != end) {
    return std::nullopt;
  }
  if (error == std::errc::result_out_of_range) {
    // Too small for a double is zero; too large is no number.
    const std::optional<Decimal> decimal = ParseDecimal(text);
    return decimal && decimal->point < 0 ? std::optional(0.0) : std::nullopt;
  }
  return error == std::errc() && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<int64_t> ParseInteger(std::string_view text) {
  text = WithoutPlus(text);
  int64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [parsed, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && parsed == end ? std::optional(value) : std::nullopt;
}

std::optional<int64_t> ParseShifted(std::string_view text, int shift) {
  const std::optional<Decimal> decimal = ParseDecimal(text);
  if (!decimal) {
    return std::nullopt;
  }
  const std::string& digits = decimal->digits;
  const int64_t point = decimal->point + shift;
  if (digits.empty() || point < 0) {
    return 0;
  }
  // So many digits cannot overflow the unsigned type.
  constexpr int64_t kMostDigits = std::numeric_limits<int64_t>::digits10 + 1;
  if (point > kMostDigits) {
    return std::nullopt;
  }
  const auto integer_digits = static_cast<std::size_t>(point);
  uint64_t value = 0;
  for (std::size_t i = 0; i < integer_digits; ++i) {
    value = 10 * value + (i < digits.size() ? static_cast<uint64_t>(digits[i] - '0') : 0);
  }
  if (integer_digits < digits.size() && digits[integer_digits] >= '5') {
    ++value;
  }
  if (value > static_cast<uint64_t>(std::numeric_limits<int64_t>::max())) {
    return std::nullopt;
  }
  return decimal->negative ? -static_cast<int64_t>(value) : static_cast<int64_t>(value);
}

std::string Lowercase(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return lower;
}

std::optional<int64_t> ParseSeconds(std::string_view text) {
  constexpr int kDecimalsOfNanoseconds = 9;
  return ParseShifted(text, kDecimalsOfNanoseconds);
}

}  // namespace gluevo::vo
