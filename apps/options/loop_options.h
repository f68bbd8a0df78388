#pragma once

#include <filesystem>

#include "command_line.h"
#include "gluevo/vo/mapping/map_culling.h"
#include "gluevo/vo/pipeline/loop_config.h"
#include "option_group.h"

namespace gluevo::apps {

/// Whether and how a run looks for places that it has seen before.
/// `save_map`: the file to keep the places in, those that `culling` leaves.
void AddLoopOptions(CLI::App& command, vo::LoopConfig& config, std::filesystem::path& save_map,
                    vo::MapCullingOptions& culling);
void AddCullingOption(OptionGroup& group, vo::MapCullingOptions& culling);

/// Once the command line is read: turns loops on where something asks for them (maps, a codebook
/// and the adjustment are made of and used by loops), else where it is the default, unless they are
/// turned off. Returns whether something asks. Throws Error where that contradicts --loops.
bool SettleLoops(CLI::App& command, bool is_default, const std::filesystem::path& save_map,
                 vo::LoopConfig& config);

/// What the records of the run say, too.
void SetLoops(CLI::App& command, bool is_on, vo::LoopConfig& config);

}  // namespace gluevo::apps
