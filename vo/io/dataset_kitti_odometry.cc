// KITTI odometry sequences (Geiger et al. 2012): rectified, one time a line.

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "groundtruth.h"
#include "kitti_files.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

// poses/NN.txt belongs to sequences/NN.
fs::path PosesOfSequence(const fs::path& sequence) {
  return sequence.parent_path().parent_path() / "poses" / (sequence.filename().string() + ".txt");
}

// The gray cameras, or the coloured ones where only these are there, as in the archive of colour
// images.
struct Cameras {
  std::array<fs::path, 2> folders;
  std::array<std::string, 2> projections;
};

Cameras CamerasOf(const fs::path& root) {
  const bool colour = !fs::is_directory(root / "image_0") && !fs::is_directory(root / "image_1") &&
                      (fs::is_directory(root / "image_2") || fs::is_directory(root / "image_3"));
  return colour ? Cameras{{root / "image_2", root / "image_3"}, {"P2", "P3"}}
                : Cameras{{root / "image_0", root / "image_1"}, {"P0", "P1"}};
}

// The poses of the sequences are camera 0's, whichever cameras are used.
void MakeCamera0TheBody(const KittiCalibration& calibration, const std::string& left,
                        StereoRig& rig) {
  const std::vector<double>& p = calibration.Get(left, 12);
  const Camera& camera = rig.cameras[0];
  const Eigen::Vector3d camera_from_camera0((p[3] - camera.cx * p[11]) / camera.fx,
                                            (p[7] - camera.cy * p[11]) / camera.fy, p[11]);
  for (Rigid3& body_from_cam : rig.body_from_cam) {
    body_from_cam.translation -= camera_from_camera0;
  }
  rig.body_frame = "camera 0";
}

}  // namespace

bool IsKittiOdometry(const fs::path& root) {
  const Cameras cameras = CamerasOf(root);
  return (fs::is_directory(cameras.folders[0]) || fs::is_directory(cameras.folders[1])) &&
         (fs::exists(root / "calib.txt") || fs::exists(root / "times.txt"));
}

Dataset OpenKittiOdometry(const fs::path& root, const DatasetOptions& options) {
  Dataset dataset;
  dataset.root = root;
  dataset.format = DatasetFormat::kKittiOdometry;
  const Cameras cameras = CamerasOf(root);
  const std::vector<ImagePair> pairs = ListNumberedPairs(cameras.folders, dataset);
  const fs::path times_file = root / "times.txt";
  const std::vector<int64_t> times = ReadTimes(times_file);
  for (const auto& [images] : pairs) {
    const auto number = static_cast<std::size_t>(images[0].key);
    if (number >= times.size()) {
      throw Error(times_file.string() + ": has " + std::to_string(times.size()) +
                  " times, none for " + images[0].path.string());
    }
    dataset.entries.push_back({times[number], {images[0].path, images[1].path}});
  }
  dataset.calibration = root / "calib.txt";
  const KittiCalibration calibration(dataset.calibration);
  dataset.rig = RectifiedRig(calibration, cameras.projections, FirstImageSize(dataset));
  if (cameras.projections[0] != "P0") {
    MakeCamera0TheBody(calibration, cameras.projections[0], dataset.rig);
  }
  for (const std::string& oddity : dataset.rig.Oddities()) {
    dataset.warnings.push_back(dataset.calibration.string() + ": " + oddity);
  }
  AddGroundtruth(options, {PosesOfSequence(FolderPath(root))}, {times, {}}, dataset);
  return dataset;
}

}  // namespace gluevo::vo
