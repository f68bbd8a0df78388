// Trajectories whose rows have no times of their own (KITTI's).

#include <algorithm>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "kitti_files.h"
#include "stamp_unit.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kSecondNs = 1'000'000'000;

// poses/NN.txt belongs to sequences/NN/times.txt in KITTI's layout, data_poses/NN/poses.txt to the
// images of data_2d_raw/NN in KITTI-360's.
std::optional<fs::path> FindKittiTimes(const fs::path& path) {
  const fs::path folder = fs::absolute(path).lexically_normal().parent_path();
  const fs::path above = folder.parent_path();
  for (const fs::path& times :
       {above / "sequences" / path.stem() / "times.txt",
        above.parent_path() / "data_2d_raw" / folder.filename() / "image_00" / "timestamps.txt"}) {
    if (fs::exists(times)) {
      return times;
    }
  }
  return std::nullopt;
}

std::vector<int64_t> ParseTimes(std::string_view text, const fs::path& path) {
  std::vector<int64_t> times;
  for (const TextLine& line : SplitLines(text, path, /*skip_comments=*/true)) {
    const auto time = ParseSeconds(line.text);
    if (!time) {
      throw Error(At(path, line) + ": " + Quoted(line.text) + " is not a time in seconds");
    }
    if (!times.empty() && *time <= times.back()) {
      throw Error(At(path, line) + ": a time that is not after the one before");
    }
    times.push_back(*time);
  }
  return times;
}

// Of times.txt, or of timestamps.txt, whose first row is a date. Read once: it may be a pipe.
std::vector<std::optional<int64_t>> ReadRowTimes(const fs::path& path) {
  const std::string text = ReadText(path);
  const std::vector<TextLine> lines = SplitLines(text, path, /*skip_comments=*/true);
  if (!lines.empty() && ParseDateTime(lines.front().text)) {
    return ParseTimestamps(text, path);
  }
  const std::vector<int64_t> seconds = ParseTimes(text, path);
  return {seconds.begin(), seconds.end()};
}

std::size_t RowOf(const StampedPose& pose) {
  return static_cast<std::size_t>(pose.timestamp_ns / kSecondNs);
}

}  // namespace

std::size_t SetRowTimes(const std::vector<std::optional<int64_t>>& times_ns, TrajectoryFile& file) {
  const std::size_t left_out = std::erase_if(file.poses, [&](const StampedPose& pose) {
    return RowOf(pose) >= times_ns.size() || !times_ns[RowOf(pose)];
  });
  for (StampedPose& pose : file.poses) {
    pose.timestamp_ns = *times_ns[RowOf(pose)];
  }
  return left_out;
}

void AddRowTimes(const fs::path& path, const std::optional<fs::path>& times, TrajectoryFile& file) {
  if (file.format != TrajectoryFormat::kKitti) {
    return;
  }
  const std::optional<fs::path> times_file = times ? times : FindKittiTimes(path);
  if (!times_file) {
    throw Error(path.string() +
                ": a KITTI file has no times: name its times.txt (--times), or keep it as "
                "poses/NN.txt beside sequences/NN/times.txt (KITTI-360: data_poses/NN/poses.txt "
                "beside data_2d_raw/NN/image_00/timestamps.txt)");
  }
  const std::vector<std::optional<int64_t>> times_ns = ReadRowTimes(*times_file);
  if (file.is_numbered && RowOf(file.poses.back()) >= times_ns.size()) {
    throw Error(path.string() + ": a pose of frame " + std::to_string(RowOf(file.poses.back())) +
                ", but " + times_file->string() + " has times of " +
                std::to_string(times_ns.size()) + " frames");
  }
  if (!file.is_numbered && file.rows != times_ns.size()) {
    throw Error(path.string() + ": " + std::to_string(file.rows) + " poses for " +
                std::to_string(times_ns.size()) + " times, expected as many");
  }
  if (const std::size_t left_out = SetRowTimes(times_ns, file); left_out > 0) {
    file.notes.push_back(Counted(left_out, "pose") + " without a time in " + times_file->string() +
                         " left out");
  }
}

Trajectory ReadTrajectory(const fs::path& path, const std::optional<fs::path>& times) {
  TrajectoryFile file = ReadTrajectoryFile(path);
  AddRowTimes(path, times, file);
  return std::move(file.poses);
}

std::vector<int64_t> ReadTimes(const fs::path& path) { return ParseTimes(ReadText(path), path); }

}  // namespace gluevo::vo
