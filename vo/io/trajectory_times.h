#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "gluevo/vo/core/trajectory.h"
#include "trajectory_columns.h"

namespace gluevo::vo {

/// Most poses come 20 a second.
inline constexpr double kTypicalPoseStepS = 0.05;

/// "seconds", ..., for messages.
std::string NameOf(TimeUnit unit);

/// The unit of a column of times, in the order of the file: by the number of digits where they
/// count from 1970; else `usual`, unless the median step would then be no time between poses (0.1
/// ms to 10 s) and is one in another unit. Times with fractions stay in seconds up to steps of
/// 1000 s, unless a header names the usual unit (`is_named`) and it is possible. What is no number
/// is passed over.
TimeUnit ChooseTimeUnit(const std::vector<std::string_view>& times, TimeUnit usual,
                        bool is_named = false, double typical_s = kTypicalPoseStepS);

/// A pose and the line it stands in.
struct PoseRow {
  int line = 0;
  StampedPose pose;
};

/// The poses in the order of their times, and a sentence for each thing that was done for it: rows
/// out of order are sorted, of rows of the same time the first one is taken. Throws Error naming
/// file and line where so many times are the same that their digits were too few.
Trajectory InOrderOfTime(const std::filesystem::path& path, std::vector<PoseRow> rows,
                         std::vector<std::string>& notes);

}  // namespace gluevo::vo
