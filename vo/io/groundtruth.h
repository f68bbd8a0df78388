#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "gluevo/vo/io/dataset.h"

namespace gluevo::vo {

/// The times of poses that have none of their own (KITTI's), nanoseconds.
struct RowTimes {
  std::vector<int64_t> rows_ns;  ///< Of row n; empty: of the data set's entry n.
  /// Of number n where rows are numbered, nothing where that has none; empty: `rows_ns`.
  std::vector<std::optional<int64_t>> frames_ns;
};

/// Gives a data set, whose entries are all there, its ground truth: options.groundtruth, else the
/// first of `candidates` that is there. Rows without times get those of `times`; where
/// they are the entries', rows that have no numbers must be as many. What is worth knowing goes to
/// the data set's warnings, and so does a candidate that cannot be used: nobody asked for it.
/// Throws Error where options.groundtruth cannot be used.
void AddGroundtruth(const DatasetOptions& options,
                    const std::vector<std::filesystem::path>& candidates, const RowTimes& times,
                    Dataset& dataset);

}  // namespace gluevo::vo
