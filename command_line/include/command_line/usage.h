#pragma once

#include <string>

#include "command_line.h"

namespace gluevo::apps {

/// Does what the command line asks `app` (gluevo, or gluevo-weights) for, and gives the exit code:
/// 0, 1 where what it asks for fails or cannot be printed, 2 where it asks for what there is not.
/// Each failure is one line on standard error.
int RunCommandLine(CLI::App& app, int argc, char** argv);

}  // namespace gluevo::apps
