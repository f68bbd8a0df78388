#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gluevo/vo/core/imu.h"

namespace gluevo::vo {

/// The rows of an inertial unit's table, in the order of the file.
struct ImuTable {
  std::vector<ImuSample> samples;     ///< Numbers as the file has them, but for units it names.
  bool is_radians_said = false;       ///< The rates were brought to rad/s as the header says.
  bool is_metres_said = false;        ///< The forces were brought to m/s^2 as the header says.
  std::vector<std::string> notes;     ///< How it was understood, a sentence each.
  std::vector<std::string> warnings;  ///< Rows that are left out, a sentence each.
};

/// Reads "t wx wy wz ax ay az" a row, in EuRoC's order or as a header names the columns; times in
/// any unit. Rows that cannot be read are left out and counted. `path` is the file's name in
/// messages. Throws Error naming the file where it is of another kind, where a header names one
/// sensor alone, where rows are too short, and where more than a tenth cannot be read.
ImuTable ParseImuTable(std::string_view text, const std::filesystem::path& path);

}  // namespace gluevo::vo
