// KITTI odometry sequences (Geiger et al. 2012): rectified, one time a line.

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "kitti_files.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

// poses/NN.txt belongs to sequences/NN.
fs::path PosesOfSequence(const fs::path& sequence) {
  return sequence.parent_path().parent_path() / "poses" / (sequence.filename().string() + ".txt");
}

}  // namespace

bool IsKittiOdometry(const fs::path& root) {
  return (fs::is_directory(root / "image_0") || fs::is_directory(root / "image_1")) &&
         (fs::exists(root / "calib.txt") || fs::exists(root / "times.txt"));
}

Dataset OpenKittiOdometry(const fs::path& root, const DatasetOptions& options) {
  Dataset dataset;
  dataset.root = root;
  dataset.format = DatasetFormat::kKittiOdometry;
  const std::vector<NumberedPair> pairs = ListNumberedPairs({root / "image_0", root / "image_1"});
  const fs::path times_file = root / "times.txt";
  const std::vector<int64_t> times = ReadTimes(times_file);
  for (const NumberedPair& pair : pairs) {
    if (pair.number >= times.size()) {
      throw Error(times_file.string() + ": has " + std::to_string(times.size()) +
                  " times, none for " + pair.images[0].string());
    }
    dataset.entries.push_back({times[pair.number], pair.images});
  }
  dataset.calibration = root / "calib.txt";
  dataset.rig = RectifiedRig(KittiCalibration(dataset.calibration), {"P0", "P1"},
                             ImageSize(pairs.front().images[0]));
  const fs::path poses = PosesOfSequence(FolderPath(root));
  if (options.groundtruth) {
    dataset.groundtruth =
        RecognizeTrajectoryFormat(*options.groundtruth) == TrajectoryFormat::kKitti
            ? ReadKittiTrajectory(*options.groundtruth, times)
            : ReadTrajectory(*options.groundtruth);
  } else if (fs::exists(poses)) {
    dataset.groundtruth = ReadKittiTrajectory(poses, times);
  }
  return dataset;
}

}  // namespace gluevo::vo
