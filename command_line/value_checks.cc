#include "command_line/value_checks.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>

#include "gluevo/nn/error.h"

namespace gluevo::apps {
namespace {

// Nothing where the text is no decimal number of this type, from its first to its last character.
template <typename Number>
std::optional<Number> Parse(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') {
    text.remove_prefix(1);  // from_chars knows no plus sign.
  }
  Number number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_whole_text = error == std::errc() && end == text.data() + text.size();
  return is_whole_text ? std::optional(number) : std::nullopt;
}

std::string Refusal(const std::string& expected, const std::string& given) {
  return "expected " + expected + ", got " + Quoted(given);
}

// Without zeros at the front, which CLI11 takes for a sign of octal numbers.
template <typename Integer, typename IsGood>
CLI::Validator WholeNumber(const std::string& expected, const std::string& in_help,
                           const IsGood& is_good) {
  return {[=](std::string& text) {
            const std::optional<Integer> number = Parse<Integer>(text);
            const std::size_t first = std::min(text.find_first_not_of("+-"), text.size());
            const bool is_octal = first + 1 < text.size() && text[first] == '0';
            return number && !is_octal && is_good(*number) ? std::string()
                                                           : Refusal(expected, text);
          },
          in_help};
}

template <typename IsGood>
CLI::Validator Number(const std::string& expected, const std::string& in_help,
                      const IsGood& is_good) {
  return {[=](std::string& text) {
            const std::optional<double> number = Parse<double>(text);
            return number && std::isfinite(*number) && is_good(*number) ? std::string()
                                                                        : Refusal(expected, text);
          },
          in_help};
}

std::string Text(double number) {
  std::ostringstream text;
  text << number;
  return text.str();
}

// As sentences list names: "a, b or c".
std::string Listed(const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    list.append(i == 0 ? "" : i + 1 < names.size() ? ", " : " or ").append(names[i]);
  }
  return list;
}

CLI::Validator Switch() {
  CLI::Validator check = OneOf({"true", "false", "on", "off", "yes", "no", "1", "0"});
  return {[check](std::string& text) {
            std::string lower = CLI::detail::to_lower(text);
            return check(lower).empty() ? std::string() : Refusal("true or false", text);
          },
          ""};
}

// An empty name is a variable of a script that was never set, not a wish for the default.
CLI::Validator NotEmpty() {
  return {[](std::string& text) {
            return text.empty() ? Refusal("a value that is not empty", text) : std::string();
          },
          ""};
}

std::optional<CLI::Validator> CheckOfType(const CLI::Option& option) {
  // Those with a check of their own have a type that tells it.
  const std::string type = option.get_type_name();
  if (type == "BOOLEAN" || option.get_items_expected_max() == 0) {
    return Switch();
  }
  if (type == "INT") {
    return WholeNumber<int>("a whole number", "", [](int) { return true; });
  }
  if (type == "UINT") {
    return WholeNumber<uint64_t>("a whole number >= 0", "", [](uint64_t) { return true; });
  }
  if (type == "FLOAT") {
    return Number("a number", "", [](double) { return true; });
  }
  return type.starts_with("TEXT") ? std::optional(NotEmpty()) : std::nullopt;
}

}  // namespace

CLI::Validator AtLeast(int low) {
  const std::string bound = ">= " + std::to_string(low);
  return WholeNumber<int>("a whole number " + bound, bound, [=](int n) { return n >= low; });
}

CLI::Validator AtLeast(double low) {
  const std::string bound = ">= " + Text(low);
  return Number("a number " + bound, bound, [=](double x) { return x >= low; });
}

CLI::Validator Above(double low) {
  const std::string bound = "> " + Text(low);
  return Number("a number " + bound, bound, [=](double x) { return x > low; });
}

CLI::Validator Within(int low, int high) {
  const std::string bounds = std::to_string(low) + " to " + std::to_string(high);
  return WholeNumber<int>("a whole number from " + bounds, bounds,
                          [=](int n) { return n >= low && n <= high; });
}

CLI::Validator Within(double low, double high) {
  const std::string bounds = Text(low) + " to " + Text(high);
  return Number("a number from " + bounds, bounds, [=](double x) { return x >= low && x <= high; });
}

CLI::Validator Share() {
  const std::string bounds = ">= 0 and < 1";
  return Number("a number " + bounds, bounds, [](double x) { return x >= 0.0 && x < 1.0; });
}

CLI::Validator OneOf(const std::vector<std::string>& names) {
  return {[names](std::string& text) {
            return std::find(names.begin(), names.end(), text) != names.end()
                       ? std::string()
                       : Refusal(Listed(names), text);
          },
          "{" + CLI::detail::join(names, ",") + "}"};
}

void CheckAllValues(CLI::App& app) {
  for (CLI::Option* const option : app.get_options()) {
    if (const std::optional<CLI::Validator> check = CheckOfType(*option)) {
      option->check(*check);
    }
  }
  for (CLI::App* const command : app.get_subcommands([](CLI::App*) { return true; })) {
    CheckAllValues(*command);
  }
}

}  // namespace gluevo::apps
