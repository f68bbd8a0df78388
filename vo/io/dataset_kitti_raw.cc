// KITTI raw drives (Geiger et al. 2013), unrectified or rectified.

#include <algorithm>
#include <optional>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "groundtruth.h"
#include "imu_source.h"
#include "kitti_files.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

// The gray cameras, or the coloured ones where only these are there. KITTI-360 calls the folder of
// rectified images data_rect, and has these cameras at a calibration of its own.
struct Cameras {
  std::array<std::string, 2> numbers;
  std::array<fs::path, 2> folders;
};

bool HasImages(const fs::path& root, const std::string& number) {
  const fs::path folder = root / ("image_" + number);
  return fs::is_directory(folder / "data") || fs::is_directory(folder / "data_rect");
}

Cameras CamerasOf(const fs::path& root) {
  const bool gray = HasImages(root, "00") || HasImages(root, "01");
  const bool colour = HasImages(root, "02") || HasImages(root, "03");
  Cameras cameras;
  cameras.numbers = !gray && colour ? std::array<std::string, 2>{"02", "03"}
                                    : std::array<std::string, 2>{"00", "01"};
  const bool kitti_360 = fs::is_directory(root / ("image_" + cameras.numbers[0]) / "data_rect") ||
                         fs::is_directory(root / ("image_" + cameras.numbers[1]) / "data_rect");
  for (std::size_t side = 0; side < 2; ++side) {
    cameras.folders[side] =
        root / ("image_" + cameras.numbers[side]) / (kitti_360 ? "data_rect" : "data");
  }
  return cameras;
}

// The body is the left camera.
StereoRig UnrectifiedRig(const KittiCalibration& calibration,
                         const std::array<std::string, 2>& numbers,
                         const std::array<int, 2>& size) {
  StereoRig rig;
  rig.body_frame = "left camera";
  std::array<Rigid3, 2> cam_from_reference;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string suffix = "_" + numbers[side];
    const std::vector<double>& k = calibration.Get("K" + suffix, 9);
    const std::vector<double>& d = calibration.Get("D" + suffix, 5);
    const std::vector<double>& t = calibration.Get("T" + suffix, 3);
    Camera& camera = rig.cameras[side];
    camera = {size[0], size[1], /*fx=*/k[0], /*fy=*/k[4], /*cx=*/k[2], /*cy=*/k[5]};
    camera.distortion = Distortion::kRadialTangential;
    std::copy(d.begin(), d.end(), camera.coefficients.begin());
    camera.Validate(calibration.path().string() + ": K" + suffix);
    cam_from_reference[side] = KittiTransform(calibration, "R" + suffix, {t[0], t[1], t[2]});
  }
  rig.body_from_cam[1] = cam_from_reference[0] * cam_from_reference[1].Inverse();
  return rig;
}

bool IsSize(const KittiCalibration& calibration, const std::string& key,
            const std::array<int, 2>& size) {
  if (!calibration.Has(key)) {
    return false;
  }
  const std::vector<double>& s = calibration.Get(key, 2);
  return s[0] == size[0] && s[1] == size[1];
}

StereoRig ReadRig(const KittiCalibration& calibration, const Cameras& cameras,
                  const fs::path& first_image, const std::array<int, 2>& size) {
  const std::array<std::string, 2>& numbers = cameras.numbers;
  // Where both are of one size, the folder tells.
  const bool rectified_folder = cameras.folders[0].filename() == "data_rect";
  if (!rectified_folder && IsSize(calibration, "S_" + numbers[0], size)) {
    return UnrectifiedRig(calibration, numbers, size);
  }
  if (IsSize(calibration, "S_rect_" + numbers[0], size)) {
    return RectifiedRig(calibration, {"P_rect_" + numbers[0], "P_rect_" + numbers[1]}, size);
  }
  throw Error(first_image.string() + ": an image of " + std::to_string(size[0]) + " x " +
              std::to_string(size[1]) + " pixels, expected S_" + numbers[0] +
              " (unrectified) or S_rect_" + numbers[0] + " (rectified) of " +
              calibration.path().string());
}

}  // namespace

bool IsKittiRaw(const fs::path& root) {
  return HasImages(root, "00") || HasImages(root, "01") || HasImages(root, "02") ||
         HasImages(root, "03");
}

Dataset OpenKittiRaw(const fs::path& root, const DatasetOptions& options) {
  Dataset dataset;
  dataset.root = root;
  dataset.format = DatasetFormat::kKittiRaw;
  const Cameras cameras = CamerasOf(root);
  const std::vector<ImagePair> pairs = ListNumberedPairs(cameras.folders, dataset);
  // Of the left camera as published, or of the drive.
  const fs::path camera_times = cameras.folders[0].parent_path() / "timestamps.txt";
  const fs::path drive_times = root / "timestamps.txt";
  const fs::path times_file =
      !fs::exists(camera_times) && fs::exists(drive_times) ? drive_times : camera_times;
  const std::vector<std::optional<int64_t>> times =
      ParseTimestamps(ReadText(times_file), times_file);
  for (const auto& [images] : pairs) {
    const auto number = static_cast<std::size_t>(images[0].key);
    if (number >= times.size() || !times[number]) {
      throw Error(times_file.string() + ": has no time in row " + std::to_string(number + 1) +
                  " of " + std::to_string(times.size()) + ", that of " + images[0].path.string());
    }
    dataset.entries.push_back({*times[number], {images[0].path, images[1].path}});
  }
  dataset.calibration = FindAbove(root, {"calib_cam_to_cam.txt", "perspective.txt",
                                         fs::path("calibration") / "perspective.txt"});
  dataset.rig = ReadRig(KittiCalibration(dataset.calibration), cameras,
                        pairs.front().images[0].path, FirstImageSize(dataset));
  AddGroundtruth(options, {}, {{}, times}, dataset);
  AddOxts(cameras.numbers[0], FirstDate(times_file), dataset);
  return dataset;
}

}  // namespace gluevo::vo
