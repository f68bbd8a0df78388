#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>

#include "command_line/value_checks.h"

namespace gluevo::apps {

/// Adds options under one heading of --help; the value that a variable has is its default.
class OptionGroup {
 public:
  OptionGroup(CLI::App& command, std::string heading)
      : command_(command), heading_(std::move(heading)) {}

  template <typename Value>
  CLI::Option* Add(const std::string& name, Value& value, const std::string& help) {
    return command_.add_option(name, value, help)->capture_default_str()->group(heading_);
  }
  /// One that is off or on.
  CLI::Option* AddSwitch(const std::string& name, bool& value, const std::string& help) {
    return Add(name, value, help)
        ->check(OneOf({"off", "on"}))
        ->default_function([&value] { return std::string(value ? "on" : "off"); })
        ->capture_default_str();
  }

 private:
  CLI::App& command_;
  std::string heading_;
};

}  // namespace gluevo::apps
