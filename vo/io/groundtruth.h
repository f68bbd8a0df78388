#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "gluevo/vo/io/dataset.h"

namespace gluevo::vo {

/// Gives a data set, whose entries are all there, its ground truth: options.groundtruth, else the
/// first of `candidates` that is there. Rows without times (KITTI's) belong to `row_times_ns`, or
/// where that is empty to the entries, which then must be as many. What is worth knowing goes to
/// the data set's warnings, and so does a candidate that cannot be used: nobody asked for it.
/// Throws Error where options.groundtruth cannot be used.
void AddGroundtruth(const DatasetOptions& options,
                    const std::vector<std::filesystem::path>& candidates,
                    const std::vector<int64_t>& row_times_ns, Dataset& dataset);

}  // namespace gluevo::vo
