#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/trajectory.h"

namespace gluevo::vo {

enum class TrajectoryFormat {
  kTum,    ///< "t x y z qx qy qz qw" a line, seconds; '#' comments.
  kEuroc,  ///< csv "t[ns],x,y,z,qw,qx,qy,qz[,...]"; '#' comments.
  kKitti,  ///< 12 numbers a line, the rows of [R | t]; no times.
};

/// Tells the formats apart by the columns and separators of the first line that is no comment.
/// Throws Error where the file cannot be read, is empty or is none of them.
TrajectoryFormat RecognizeTrajectoryFormat(const std::filesystem::path& path);

/// Reads any of the three formats. A KITTI file has no times: they come from `times` (KITTI's
/// times.txt, seconds a line, as many lines as poses), or from ../sequences/NN/times.txt for
/// poses/NN.txt, else Error; the other formats leave `times` unread. Times are exact to the
/// nanosecond, whatever the number of digits. Throws Error with file and line for anything
/// malformed, values that are not finite, quaternions whose length differs from 1 (or rotations
/// that differ from a right-handed orthonormal matrix) by more than 0.01, and times that do not
/// increase.
Trajectory ReadTrajectory(const std::filesystem::path& path,
                          const std::optional<std::filesystem::path>& times = std::nullopt);

/// Reads a KITTI file whose row n belongs to times_ns[n]. Throws Error as above, and where the
/// numbers of rows and of times differ.
Trajectory ReadKittiTrajectory(const std::filesystem::path& path,
                               const std::vector<int64_t>& times_ns);

/// Reads a KITTI file on its own, row n at n seconds: two files of the same sequence associate by
/// their rows.
Trajectory ReadKittiTrajectoryByRow(const std::filesystem::path& path);

/// Reads times, seconds a line ('#' comments), as nanoseconds. Throws Error with file and line for
/// anything malformed and for times that do not increase.
std::vector<int64_t> ReadTimes(const std::filesystem::path& path);

/// Writes beside the place first, then renames. Each line of `header` becomes a comment line (TUM,
/// EuRoC; KITTI files know none). TUM times have 9 decimals and are exact. Throws Error where the
/// file cannot be written.
void WriteTrajectory(const std::filesystem::path& path, const Trajectory& trajectory,
                     TrajectoryFormat format, const std::string& header);

}  // namespace gluevo::vo
