#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "column_names.h"

namespace gluevo::vo {

/// Where the numbers of a pose stand in the row of a table, from 0.
struct PoseColumns : TimeColumn {
  std::array<std::size_t, 3> position = {1, 2, 3};     ///< x y z
  std::array<std::size_t, 4> rotation = {4, 5, 6, 7};  ///< The quaternion's x y z w.
  double metres = 1.0;                                 ///< Of one unit of position.
  /// The quaternion is named q0 to q3: its w first, as most write it.
  bool is_numbered = false;

  /// Columns that a row must have.
  std::size_t Count() const;
};

/// EuRoC's order: t x y z qw qx qy qz.
PoseColumns ColumnsWithWFirst();

/// The columns that the first line of a table names, in any of the ways of their tools: "t",
/// "timestamp [ns]", "secs" and "nsecs"; "x", "tx", "p_RS_R_x [m]", "pose.position.x"; "qw",
/// "q_RS_w []", "orientation.w", "rw", "ow", "q0" (w) to "q3". Nothing unless time, position and
/// quaternion are all named.
std::optional<PoseColumns> ColumnsOfHeader(std::string_view header);

/// How many columns a line names whose first or last name is one of a time; 0 of other lines.
std::size_t ColumnsNamed(std::string_view header);

}  // namespace gluevo::vo
