#include "yaml_config.h"

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"
#include "yaml_text.h"

namespace gluevo::apps {
namespace {

// A value or a list of values; none of anything else.
std::vector<std::string> Values(const YAML::Node& node) {
  if (node.IsScalar()) {
    return {node.as<std::string>()};
  }
  std::vector<std::string> values;
  values.reserve(node.size());
  for (const YAML::Node& item : node) {
    if (!node.IsSequence() || !item.IsScalar()) {
      return {};
    }
    values.push_back(item.as<std::string>());
  }
  return values;
}

// Those that the option can take.
std::vector<std::string> ValuesFor(const CLI::Option& option, const YAML::Node& node,
                                   const std::string& where, const std::string& name) {
  std::vector<std::string> values = Values(node);
  const bool takes_several = option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  if (values.empty() || (node.IsSequence() && !takes_several)) {
    throw OptionError(where + ": expected " +
                      (takes_several ? "a value or a list of values" : "one value") +
                      " of option " + name);
  }
  return values;
}

}  // namespace

void ApplyYamlConfig(CLI::App& command, const std::filesystem::path& file) {
  const YAML::Node root = ReadYamlText(file);
  if (!root.IsMap()) {
    throw Error(file.string() + ": expected a map of option names to values");
  }
  CheckKeys(root, file);
  for (const auto& entry : root) {
    const std::string where = YamlPlace(file, entry.first);
    const std::string& name = entry.first.Scalar();
    CLI::Option* const option = command.get_option_no_throw("--" + name);
    if (option == nullptr || name == "config" || name == "help") {
      throw OptionError(where + ": unknown option " + Quoted(name) +
                        ", expected a long option of 'gluevo " + command.get_name() + "'");
    }
    const std::vector<std::string> values = ValuesFor(*option, entry.second, where, name);
    if (option->count() > 0) {
      continue;
    }
    try {
      option->add_result(values);
      option->run_callback();
    } catch (const CLI::Error& error) {
      throw OptionError(where + ": " + error.what());
    }
  }
}

}  // namespace gluevo::apps
