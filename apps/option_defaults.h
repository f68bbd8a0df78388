#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace gluevo::apps {

/// Gives an option a value where neither command line nor configuration gave one, as if it had been
/// given: records of the run show it.
inline void SetUnlessGiven(CLI::App& command, const std::string& option, const std::string& value) {
  CLI::Option* const found = command.get_option(option);
  if (found->count() == 0) {
    found->add_result(value);
    found->run_callback();
  }
}

}  // namespace gluevo::apps
