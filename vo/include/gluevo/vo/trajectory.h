#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/rigid3.h"

namespace gluevo::vo {

struct StampedPose {
  int64_t timestamp_ns = 0;  // nanoseconds, the data set's clock
  Rigid3 world_from_body;
};

/// Poses in order of time.
using Trajectory = std::vector<StampedPose>;

enum class TrajectoryFormat {
  kTum,    ///< "t x y z qx qy qz qw" a line, seconds; '#' comments.
  kEuroc,  ///< csv "t[ns],x,y,z,qw,qx,qy,qz[,...]"; '#' comments.
  kKitti,  ///< 12 numbers a line, the rows of [R | t]; no times.
};

/// Reads any of the three formats (told apart by their columns and separators). A KITTI file has no
/// times: they come from `times` (KITTI's times.txt, seconds a line), or from
/// ../sequences/NN/times.txt for poses/NN.txt, else Error. Throws Error with file and line for
/// anything malformed, values that are not finite, quaternions that are far from unit length, and
/// times that do not increase.
Trajectory ReadTrajectory(const std::filesystem::path& path,
                          const std::optional<std::filesystem::path>& times = std::nullopt);

/// Writes beside the place first, then renames. `header` goes into a comment line (TUM, EuRoC).
/// TUM times have 9 decimals.
void WriteTrajectory(const std::filesystem::path& path, const Trajectory& trajectory,
                     TrajectoryFormat format, const std::string& header);

}  // namespace gluevo::vo
