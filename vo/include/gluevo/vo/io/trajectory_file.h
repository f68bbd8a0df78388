#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gluevo/vo/core/trajectory.h"

namespace gluevo::vo {

enum class TrajectoryFormat {
  kTum,  ///< A table between blanks, by default "t x y z qx qy qz qw" in seconds, or t and [R | t].
  kEuroc,  ///< A table between commas or semicolons, by default "t[ns],x,y,z,qw,qx,qy,qz[,...]".
  kKitti,  ///< 12 numbers a line, the rows of [R | t] (or 16, with 0 0 0 1), perhaps behind the
           ///< frame's number (KITTI-360); no times.
};

/// A trajectory file's content.
struct TrajectoryFile {
  TrajectoryFormat format = TrajectoryFormat::kTum;
  /// In order of time. Of kKitti, which has no times: row n, from 0, at n seconds; or frame n.
  Trajectory poses;
  bool is_numbered = false;  ///< Of kKitti: rows say the numbers of their frames.
  std::size_t rows = 0;      ///< Of the file, those without a pose too.
  /// A sentence for each thing that a user should know of how the file was read: an unusual unit or
  /// order, rows left out, sorted rows, quaternions made unit length.
  std::vector<std::string> notes;
};

/// Reads a trajectory from text; `path` is its name in messages, and not opened. Comments ('#', '%'
/// or "//") and words before the first row are passed over; where they name the columns, in the
/// ways of many tools, their order and unit are heeded. Else the form's default order is taken, and
/// columns behind it are passed over. The unit of times is told by their digits and distances.
/// Times are exact to the nanosecond, whatever the number of digits. Rows with NaN, infinity or
/// nothing in a pose are left out; rows are sorted; of rows with the same time the first is taken;
/// quaternions are made unit length: all that is in `notes`. Throws Error with file and line for
/// anything else that is malformed, quaternions shorter than 0.1 or longer than 10, rotations that
/// differ from a right-handed orthonormal matrix by more than 0.01, times that are the same for
/// want of digits, and text that is no UTF-8.
TrajectoryFile ParseTrajectory(std::string_view text, const std::filesystem::path& path);

/// Reads a file so. Throws Error, too, where it cannot be read.
TrajectoryFile ReadTrajectoryFile(const std::filesystem::path& path);

/// Gives row n, or frame n, of a kKitti file the time times_ns[n]; rows that have none, or are
/// beyond the last one, are left out. Returns how many.
std::size_t SetRowTimes(const std::vector<std::optional<int64_t>>& times_ns, TrajectoryFile& file);

/// Gives a kKitti file times: of `times` (KITTI's times.txt, seconds a line, or its timestamps.txt,
/// of which rows may be blank), or from ../sequences/NN/times.txt for poses/NN.txt, or (KITTI-360)
/// from ../../data_2d_raw/NN/image_00/timestamps.txt for data_poses/NN/poses.txt, `path` being the
/// file's own; else Error, as it is where there are not as many as poses, or, of numbered ones,
/// fewer than the last number asks for. The other formats are left as they are, and `times` unread.
void AddRowTimes(const std::filesystem::path& path,
                 const std::optional<std::filesystem::path>& times, TrajectoryFile& file);

/// The poses of a file with what AddRowTimes adds.
Trajectory ReadTrajectory(const std::filesystem::path& path,
                          const std::optional<std::filesystem::path>& times = std::nullopt);

/// Reads times, seconds a line ('#' comments), as nanoseconds. Throws
/// Error with file and line for anything malformed and for times that do not increase.
std::vector<int64_t> ReadTimes(const std::filesystem::path& path);

/// Writes beside the place first, then renames. Each line of `header` becomes a comment line (TUM,
/// EuRoC; KITTI files know none). TUM times have 9 decimals and are exact. Throws Error where the
/// file cannot be written.
void WriteTrajectory(const std::filesystem::path& path, const Trajectory& trajectory,
                     TrajectoryFormat format, const std::string& header);

}  // namespace gluevo::vo
