#pragma once

#include "command_line.h"
#include "gluevo/vo/pipeline/odometry_config.h"

namespace gluevo::apps {

/// Fills config.frontend and config.threads.
void AddFrontEndOptions(CLI::App& command, vo::OdometryConfig& config);

}  // namespace gluevo::apps
