#pragma once

#include <filesystem>

#include "run_outputs.h"

namespace gluevo::apps {

/// Throws Error where a run would replace what no run made: any file at the place of the stored
/// matches (empty: none), and below the data set's folder any at the place of another result.
void CheckReplacesOnlyResults(const RunPlaces& places, const std::filesystem::path& matches,
                              const std::filesystem::path& dataset);

}  // namespace gluevo::apps
