#pragma once

#include <filesystem>
#include <vector>

#include "gluevo/vo/core/trajectory.h"

namespace gluevo::apps {

/// The segment of each pose of a trajectory, as the metrics.json of the run that made it says: by
/// its row where the trajectory has a pose for every frame, else by its time. Throws Error where
/// the file cannot be read, has no segments, or has none for a pose.
std::vector<int> ReadSegments(const std::filesystem::path& metrics_file,
                              const vo::Trajectory& trajectory);

}  // namespace gluevo::apps
