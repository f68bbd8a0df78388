#pragma once

#include "command_line.h"
#include "gluevo/vo/pipeline/odometry_config.h"

namespace gluevo::apps {

/// Fills config.frontend and config.threads.
void AddFrontEndOptions(CLI::App& command, vo::OdometryConfig& config);

/// For a command in which frames do not wait: what networks make of a frame is taken in as soon as
/// it is there, unless a lag is given. Before the command line is read, and after.
void DescribeLagByClock(CLI::App& command);
void UseLagByClock(CLI::App& command, vo::LearnedFrontEndOptions& options);

}  // namespace gluevo::apps
