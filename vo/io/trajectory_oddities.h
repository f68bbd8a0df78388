#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <string_view>
#include <vector>

#include "text_file.h"

namespace gluevo::vo {

/// Counts of what is not as it should be in a trajectory, each with the line where it is first.
struct TrajectoryOddities {
  struct Count {
    std::size_t rows = 0;
    int first_line = 0;
    void Add(int line) { first_line = rows++ == 0 ? line : first_line; }
  };
  Count no_pose;
  Count zeros;
  Count not_normalized;
  /// Lengths of the quaternions that are not normalized.
  double shortest = std::numeric_limits<double>::infinity();
  double longest = 0.0;
};

/// What trackers write where they have no pose: "nan", "-inf", "1.#QNAN", "None", or nothing.
bool IsNoValue(std::string_view field);

/// Whether a row tells that there is no pose: "12.5 lost", or a time alone.
bool IsWithoutPose(const std::vector<std::string_view>& fields);

/// A number of a row. Throws Error naming the line where it is none.
double ParseField(const std::filesystem::path& path, const TextLine& line, std::string_view field);

}  // namespace gluevo::vo
