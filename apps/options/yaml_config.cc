#include "yaml_config.h"

#include <yaml-cpp/yaml.h>
#include <CLI/CLI.hpp>

#include <string>

#include "gluevo/nn/error.h"

namespace gluevo::apps {

void ApplyYamlConfig(CLI::App& command, const std::filesystem::path& file) {
  const auto at_line = [&](int line) { return file.string() + ":" + std::to_string(line + 1); };
  YAML::Node root;
  try {
    root = YAML::LoadFile(file.string());
  } catch (const YAML::BadFile&) {
    throw Error(file.string() + ": cannot be read (--config)");
  } catch (const YAML::ParserException& error) {
    throw Error(at_line(error.mark.line) + ": not YAML: " + error.msg);
  }
  if (!root.IsMap()) {
    throw Error(file.string() + ": expected a map of option names to values");
  }
  for (const auto& entry : root) {
    const std::string where = at_line(entry.first.Mark().line);
    const auto name = entry.first.as<std::string>();
    CLI::Option* const option = command.get_option_no_throw("--" + name);
    if (option == nullptr || name == "config" || name == "help") {
      throw Error(where + ": unknown option " + Quoted(name) +
                  ", expected a long option of 'gluevo " + command.get_name() + "'");
    }
    if (!entry.second.IsScalar()) {
      throw Error(where + ": option " + name + " takes one value");
    }
    if (option->count() > 0) {
      continue;
    }
    try {
      option->add_result(entry.second.as<std::string>());
      option->run_callback();
    } catch (const CLI::Error& error) {
      throw Error(where + ": " + error.what());
    }
  }
}

}  // namespace gluevo::apps
