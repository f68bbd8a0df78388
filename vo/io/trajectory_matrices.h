#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gluevo/vo/core/trajectory.h"
#include "trajectory_layout.h"
#include "trajectory_oddities.h"

namespace gluevo::vo {

/// The poses of rows that hold matrices [R | t], in order of time: at the time that stands before
/// the matrix, else at as many seconds as the frame's number there says, else row n at n seconds.
/// Throws Error naming file and line where a row is malformed.
Trajectory ParseMatrices(const std::filesystem::path& path, const TrajectoryLines& lines,
                         const TrajectoryLayout& layout, TrajectoryOddities& oddities,
                         std::vector<std::string>& notes);

}  // namespace gluevo::vo
