#pragma once

#include <filesystem>

#include "gluevo/vo/evaluation.h"
#include "gluevo/vo/trajectory.h"

namespace gluevo::apps {

/// Draws the SE(3)-aligned estimate over the ground truth as an SVG file, along the two world axes
/// in which the ground truth extends most. Throws Error where it cannot be written.
void WriteTrajectoryPlot(const std::filesystem::path& path, const vo::Trajectory& estimate,
                         const vo::Trajectory& groundtruth, const vo::Evaluation& evaluation);

}  // namespace gluevo::apps
