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
/// where a replay runs none, the network's threshold where it does not match from left to right,
/// and a lag of the networks that lets them run less often than asked for. `frontend`: as the
/// preset leaves it; its method is `method`, but for a replay.
std::vector<std::string> UnusedFrontEndOptions(const CLI::App& command, const std::string& method,
                                               bool is_replay, const vo::FrontEndConfig& frontend);

}  // namespace gluevo::apps
