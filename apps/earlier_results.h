#pragma once

#include <filesystem>
#include <vector>

#include "run_outputs.h"

namespace gluevo::apps {

/// Throws Error where a run would replace what no run made: any file at the place of the stored
/// matches (empty: none), and below the data set's folder any at the place of another result.
void CheckReplacesOnlyResults(const RunPlaces& places, const std::filesystem::path& matches,
                              const std::filesystem::path& dataset);

/// The trajectories that an earlier run may have left in the folder, by the metrics.json that is
/// there, and that this one does not write: of another format, or those that it is not asked for.
std::vector<std::filesystem::path> StaleTrajectories(const RunPlaces& places);

}  // namespace gluevo::apps
