#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>

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

 private:
  CLI::App& command_;
  std::string heading_;
};

}  // namespace gluevo::apps
