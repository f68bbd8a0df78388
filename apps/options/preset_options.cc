#include "preset_options.h"

#include <CLI/CLI.hpp>
#include <vector>

#include "command_line/value_checks.h"
#include "gluevo/vo/pipeline/presets.h"

namespace gluevo::apps {
namespace {

// The options' defaults become `values`; what was set stays.
void Rebase(CLI::App& command, const vo::OdometryConfig& values, vo::OdometryConfig& config) {
  config = values;
  for (CLI::Option* const option : command.get_options()) {
    if (option->count() > 0) {
      option->run_callback();
    } else if (!option->get_default_str().empty()) {
      option->capture_default_str();
    }
  }
}

// Notes for options whose default is another than before.
void NoteChanges(const CLI::App& command, const std::string& origin,
                 std::map<std::string, std::string>& defaults, OptionOrigins& origins) {
  for (const CLI::Option* const option : command.get_options()) {
    std::string& before = defaults[option->get_single_name()];
    if (option->get_default_str() != before) {
      before = option->get_default_str();
      origins.origins[option->get_single_name()] = origin;
    }
  }
}

}  // namespace

void AddPresetOption(CLI::App& command, std::string& preset) {
  std::vector<std::string> names;
  std::string list;
  for (const vo::Preset& known : vo::Presets()) {
    names.push_back(known.name);
    list += (list.empty() ? "" : ", ") + known.name + " (" + known.description + ")";
  }
  command
      .add_option("--preset", preset,
                  "Values of options that nothing else gives: " + list +
                      "; default: by the kind of data set")
      ->check(OneOf(names));
}

std::map<std::string, bool> OptionsGiven(const CLI::App& command) {
  std::map<std::string, bool> given;
  for (const CLI::Option* const option : command.get_options()) {
    given[option->get_single_name()] = option->count() > 0;
  }
  return given;
}

OptionOrigins ApplyPreset(CLI::App& command, const std::string& asked, vo::DatasetFormat format,
                          const std::map<std::string, bool>& given, vo::OdometryConfig& config) {
  OptionOrigins origins;
  origins.preset = asked.empty() ? vo::PresetOf(format) : asked;
  std::map<std::string, std::string> defaults;
  for (const CLI::Option* const option : command.get_options()) {
    const std::string name = option->get_single_name();
    defaults[name] = option->get_default_str();
    if (name != "help") {
      origins.origins[name] = "default";
    }
  }
  const auto preset_config = [method = config.frontend.method, features = config.frontend.features,
                              matcher = config.frontend.matcher](const std::string& preset) {
    return vo::PresetConfig(preset, method, features, matcher);
  };
  Rebase(command, preset_config(vo::Presets().front().name), config);
  NoteChanges(command, "method", defaults, origins);
  Rebase(command, preset_config(origins.preset), config);
  NoteChanges(command, "preset", defaults, origins);
  for (const auto& [name, was_set] : OptionsGiven(command)) {
    if (was_set) {
      origins.origins[name] = given.at(name) ? "command line" : "file";
    }
  }
  origins.preset_from = asked.empty() ? "data set" : origins.origins["preset"];
  return origins;
}

}  // namespace gluevo::apps
