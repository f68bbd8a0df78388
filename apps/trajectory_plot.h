#pragma once

#include <filesystem>
#include <string>

#include "trajectory_lines.h"

namespace gluevo::apps {

/// Draws an estimate over ground truth as an SVG file, with a caption. Throws Error where it cannot
/// be written.
void WriteTrajectoryPlot(const std::filesystem::path& path, const TrajectoryLines& lines,
                         const std::string& caption);

}  // namespace gluevo::apps
