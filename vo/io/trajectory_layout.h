#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gluevo/vo/io/trajectory_file.h"
#include "text_file.h"
#include "trajectory_columns.h"

namespace gluevo::vo {

/// The rows of a trajectory, without comments and blank lines, and the columns that a line before
/// the first of them names (a comment or not).
struct TrajectoryLines {
  std::vector<TextLine> rows;
  std::optional<PoseColumns> header;
  /// A line before the first row that names columns, but not all of a pose's in a way known here.
  std::optional<TextLine> unknown_header;
  bool is_ended = true;  ///< The last row has a line end.
};

/// Throws Error naming the file where it is no text or has no rows.
TrajectoryLines SplitTrajectoryLines(std::string_view text, const std::filesystem::path& path);

/// How to read each row.
struct TrajectoryLayout {
  TrajectoryFormat format = TrajectoryFormat::kTum;
  char separator = ' ';
  PoseColumns columns;  ///< Of rows that hold no matrix.
  /// The column where the matrix [R | t] begins: 0, or 1 behind a frame's number (kKitti) or a time
  /// (kTum).
  std::optional<std::size_t> matrix_column;
  TimeUnit unit = TimeUnit::kSeconds;  ///< Usual in such files.
  bool is_named = false;               ///< A header names the columns.
  std::string description;             ///< Of a row, for messages.
};

/// The layout by the header, else by the first row; a sentence where a row has more columns than
/// are read. Throws Error naming the first row's line where it is none.
TrajectoryLayout LayoutOf(const std::filesystem::path& path, const TrajectoryLines& lines,
                          std::vector<std::string>& notes);

/// Numbers between commas are EuRoC's nanoseconds with qw first, unless a header says otherwise:
/// with seconds they are TUM's, with qw last.
void FitOrderToUnit(TimeUnit unit, TrajectoryLayout& layout, std::vector<std::string>& notes);

}  // namespace gluevo::vo
