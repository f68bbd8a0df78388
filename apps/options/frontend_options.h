#pragma once

#include <string>
#include <vector>

#include "command_line.h"
#include "gluevo/vo/pipeline/odometry_config.h"

namespace gluevo::apps {

/// Fills config.frontend and config.threads.
void AddFrontEndOptions(CLI::App& command, vo::OdometryConfig& config);

/// For a command in which frames do not wait: what networks make of a frame is taken in as soon as
/// it is there, unless a lag is given. Before the command line is read, and after.
void DescribeLagByClock(CLI::App& command);
void UseLagByClock(CLI::App& command, vo::LearnedFrontEndOptions& options);

/// A sentence for what was given and is without effect: options of other methods, of a front end
/// where a replay runs none, and a lag of the networks that lets them run less often than asked
/// for. `learned`: as the preset leaves it.
std::vector<std::string> UnusedFrontEndOptions(const CLI::App& command, const std::string& method,
                                               bool is_replay,
                                               const vo::LearnedFrontEndOptions& learned);

}  // namespace gluevo::apps
