#include "groundtruth.h"

#include <algorithm>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

void SetTimes(const fs::path& path, const Dataset& dataset,
              const std::vector<int64_t>& row_times_ns, TrajectoryFile& file) {
  std::vector<int64_t> times_ns = row_times_ns;
  for (std::size_t i = 0; row_times_ns.empty() && i < dataset.entries.size(); ++i) {
    times_ns.push_back(dataset.entries[i].timestamp_ns);
  }
  const std::string counts = std::to_string(file.rows) + " poses for " +
                             std::to_string(times_ns.size()) +
                             (row_times_ns.empty() ? " stereo pairs" : " times");
  if (file.rows != times_ns.size()) {
    if (row_times_ns.empty()) {
      throw Error(path.string() + ": " + counts +
                  ", expected as many: its rows have no times (KITTI's form)");
    }
    file.notes.push_back(counts + ": row n belongs to time n, the rest is left out");
  }
  SetRowTimes(times_ns, file);
}

Trajectory Read(const fs::path& path, const std::vector<int64_t>& row_times_ns, Dataset& dataset) {
  TrajectoryFile file = ReadTrajectoryFile(path);
  if (file.format == TrajectoryFormat::kKitti) {
    SetTimes(path, dataset, row_times_ns, file);
  }
  for (const std::string& note : file.notes) {
    dataset.warnings.push_back("ground truth " + path.string() + ": " + note);
  }
  return std::move(file.poses);
}

}  // namespace

void AddGroundtruth(const DatasetOptions& options, const std::vector<fs::path>& candidates,
                    const std::vector<int64_t>& row_times_ns, Dataset& dataset) {
  if (options.groundtruth) {
    dataset.groundtruth = Read(*options.groundtruth, row_times_ns, dataset);
    return;
  }
  const auto found = std::find_if(candidates.begin(), candidates.end(),
                                  [](const fs::path& path) { return fs::exists(path); });
  if (found == candidates.end()) {
    return;
  }
  try {
    dataset.groundtruth = Read(*found, row_times_ns, dataset);
  } catch (const Error& error) {
    dataset.warnings.push_back(std::string("the data set's ground truth is not used: ") +
                               error.what());
  }
}

}  // namespace gluevo::vo
