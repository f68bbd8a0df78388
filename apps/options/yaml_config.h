#pragma once

#include <filesystem>

#include "command_line.h"

namespace gluevo::apps {

/// Takes options from a YAML file: a map of the command's long option names (without dashes) to
/// values, or lists of values for options that may be given more than once. What the command line
/// gives goes before. Throws Error naming file and line for what is no such map, OptionError for
/// unknown names and values that the option refuses.
void ApplyYamlConfig(CLI::App& command, const std::filesystem::path& file);

}  // namespace gluevo::apps
