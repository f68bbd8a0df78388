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

/// Maps are made of and used by loops: turns them on where one is asked for. Throws Error where
/// they were turned off.
void TurnOnForMaps(CLI::App& command, vo::LoopConfig& config,
                   const std::filesystem::path& save_map);

}  // namespace gluevo::apps
