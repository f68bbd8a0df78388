#include "groundtruth.h"

#include <algorithm>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/io/trajectory_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

using Times = std::vector<std::optional<int64_t>>;

Times TimesOf(const Dataset& dataset) {
  Times times_ns;
  times_ns.reserve(dataset.entries.size());
  for (const Dataset::Entry& entry : dataset.entries) {
    times_ns.emplace_back(entry.timestamp_ns);
  }
  return times_ns;
}

void SetFrameTimes(const fs::path& path, const Times& times_ns, TrajectoryFile& file) {
  const std::size_t left_out = SetRowTimes(times_ns, file);
  if (file.poses.empty()) {
    throw Error(path.string() + ": no pose of the data set's frames 0 to " +
                std::to_string(times_ns.size() - 1) + ": its rows are of other ones");
  }
  constexpr const char* kNameOfBody = "poses.txt";
  file.notes.push_back("the rows' first numbers are taken as those of frames" +
                       (left_out == 0 ? std::string()
                                      : "; " + Counted(left_out, "row is", "rows are") +
                                            " of frames without a time: left out"));
  if (path.filename() == kNameOfBody) {
    file.notes.emplace_back(
        "KITTI-360's poses.txt is of the GPS unit; the left camera's path is cam0_to_world.txt");
  }
}

void SetTimes(const fs::path& path, const Dataset& dataset, const RowTimes& known,
              TrajectoryFile& file) {
  const std::vector<int64_t>& row_times_ns = known.rows_ns;
  const Times times_ns =
      row_times_ns.empty() ? TimesOf(dataset) : Times(row_times_ns.begin(), row_times_ns.end());
  if (file.is_numbered) {
    SetFrameTimes(path, known.frames_ns.empty() ? times_ns : known.frames_ns, file);
    return;
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

Trajectory Read(const fs::path& path, const RowTimes& times, Dataset& dataset) {
  TrajectoryFile file = ReadTrajectoryFile(path);
  if (file.format == TrajectoryFormat::kKitti) {
    SetTimes(path, dataset, times, file);
  }
  for (const std::string& note : file.notes) {
    dataset.warnings.push_back("ground truth " + path.string() + ": " + note);
  }
  return std::move(file.poses);
}

}  // namespace

void AddGroundtruth(const DatasetOptions& options, const std::vector<fs::path>& candidates,
                    const RowTimes& times, Dataset& dataset) {
  if (options.groundtruth) {
    dataset.groundtruth = Read(*options.groundtruth, times, dataset);
    return;
  }
  const auto found = std::find_if(candidates.begin(), candidates.end(),
                                  [](const fs::path& path) { return fs::exists(path); });
  if (found == candidates.end()) {
    return;
  }
  try {
    dataset.groundtruth = Read(*found, times, dataset);
  } catch (const Error& error) {
    dataset.warnings.push_back(std::string("the data set's ground truth is not used: ") +
                               error.what());
  }
}

}  // namespace gluevo::vo
