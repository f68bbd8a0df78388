#pragma once

#include "command_line.h"
#include "gluevo/vo/pipeline/loop_config.h"

namespace gluevo::apps {

/// Whether and how a run looks for places that it has seen before.
void AddLoopOptions(CLI::App& command, vo::LoopConfig& config);

}  // namespace gluevo::apps
