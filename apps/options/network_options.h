#pragma once

#include "command_line.h"
#include "gluevo/nn/superpoint.h"
#include "gluevo/vo/pipeline/networks.h"

namespace gluevo::apps {

/// Which networks a command runs, and on how many threads (0: one a processor).
void AddNetworkOptions(CLI::App& command, vo::NetworkFiles& files, int& threads);

void AddSuperPointOptions(CLI::App& command, nn::SuperPointOptions& options);

}  // namespace gluevo::apps
