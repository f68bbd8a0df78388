// Trajectories whose rows have no times of their own (KITTI's).

#include <algorithm>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kSecondNs = 1'000'000'000;

// poses/NN.txt belongs to sequences/NN/times.txt in KITTI's layout.
std::optional<fs::path> FindKittiTimes(const fs::path& path) {
  const fs::path times =
      fs::absolute(path).parent_path().parent_path() / "sequences" / path.stem() / "times.txt";
  return fs::exists(times) ? std::optional(times) : std::nullopt;
}

}  // namespace

void SetRowTimes(const std::vector<int64_t>& times_ns, TrajectoryFile& file) {
  const auto row = [](const StampedPose& pose) {
    return static_cast<std::size_t>(pose.timestamp_ns / kSecondNs);
  };
  std::erase_if(file.poses, [&](const StampedPose& pose) { return row(pose) >= times_ns.size(); });
  for (StampedPose& pose : file.poses) {
    pose.timestamp_ns = times_ns[row(pose)];
  }
}

TrajectoryFile ReadTrajectoryWithTimes(const fs::path& path, const std::optional<fs::path>& times) {
  TrajectoryFile file = ReadTrajectoryFile(path);
  if (file.format != TrajectoryFormat::kKitti) {
    return file;
  }
  const std::optional<fs::path> times_file = times ? times : FindKittiTimes(path);
  if (!times_file) {
    throw Error(path.string() +
                ": a KITTI file has no times: name its times.txt (--times), or keep it as "
                "poses/NN.txt beside sequences/NN/times.txt");
  }
  const std::vector<int64_t> times_ns = ReadTimes(*times_file);
  if (file.rows != times_ns.size()) {
    throw Error(path.string() + ": " + std::to_string(file.rows) + " poses for " +
                std::to_string(times_ns.size()) + " times, expected as many");
  }
  SetRowTimes(times_ns, file);
  return file;
}

Trajectory ReadTrajectory(const fs::path& path, const std::optional<fs::path>& times) {
  return ReadTrajectoryWithTimes(path, times).poses;
}

std::vector<int64_t> ReadTimes(const fs::path& path) {
  std::vector<int64_t> times;
  for (const TextLine& line : ReadLines(path, /*skip_comments=*/true)) {
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

}  // namespace gluevo::vo
