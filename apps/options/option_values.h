#pragma once

#include <map>
#include <string>
#include <vector>

#include "command_line.h"

namespace gluevo::apps {

/// Values by the long name of their option.
using OptionValueMap = std::map<std::string, std::vector<std::string>>;

/// What every option of a command has, defaults too: one value, or those of an option that was
/// given more than once.
OptionValueMap OptionValues(const CLI::App& command);

/// One value as it is, several as a JSON list.
std::string ValueText(const std::vector<std::string>& values);

}  // namespace gluevo::apps
