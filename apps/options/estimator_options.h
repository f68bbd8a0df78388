#pragma once

#include "command_line.h"
#include "gluevo/vo/pipeline/odometry_options.h"

namespace gluevo::apps {

void AddEstimatorOptions(CLI::App& command, vo::OdometryOptions& options);

}  // namespace gluevo::apps
