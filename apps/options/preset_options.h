#pragma once

#include <map>
#include <string>

#include "command_line.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/pipeline/odometry_config.h"

namespace gluevo::apps {

/// Where the values of a command's options come from.
struct OptionOrigins {
  std::string preset;
  std::string preset_from;  ///< "data set", "command line" or "file".
  /// By option: "command line", "file" (--config), "preset", "method" or "default".
  std::map<std::string, std::string> origins;
};

void AddPresetOption(CLI::App& command, std::string& preset);

/// Gives the options that neither the command line nor a configuration file set the values of the
/// preset (`asked`, or where that is empty the data set's own). `config` is what the command's
/// options fill; `given` the options that the command line set.
OptionOrigins ApplyPreset(CLI::App& command, const std::string& asked, vo::DatasetFormat format,
                          const std::map<std::string, bool>& given, vo::OdometryConfig& config);

/// Which options have been set so far, by name.
std::map<std::string, bool> OptionsGiven(const CLI::App& command);

}  // namespace gluevo::apps
