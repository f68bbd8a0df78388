#include "option_values.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

namespace gluevo::apps {

OptionValueMap OptionValues(const CLI::App& command) {
  OptionValueMap values;
  for (const CLI::Option* const option : command.get_options()) {
    const std::string name = option->get_single_name();
    if (name == "help" || (option->count() == 0 && option->get_default_str().empty())) {
      continue;
    }
    if (option->count() == 0) {
      values[name] = {option->get_default_str()};
    } else if (option->count() == 1) {
      values[name] = {option->as<std::string>()};
    } else {
      values[name] = option->results();
    }
  }
  return values;
}

std::string ValueText(const std::vector<std::string>& values) {
  using nlohmann::json;
  return values.size() == 1
             ? values[0]
             : json(values).dump(-1, ' ', /*ensure_ascii=*/false, json::error_handler_t::replace);
}

}  // namespace gluevo::apps
