#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::vo {

enum class DatasetFormat {
  kEuroc,          ///< EuRoC ASL and TUM-VI: mav0/cam0, mav0/cam1.
  kKittiOdometry,  ///< image_0, image_1, calib.txt, times.txt.
  /// image_00/data, image_01/data, image_00/timestamps.txt, calib_cam_to_cam.txt here or up to
  /// three folders above. Times count from the first row of timestamps.txt.
  kKittiRaw,
  /// Two folders (left and right, cam0 and cam1, image_0 and image_1, image_00 and image_01) of
  /// images that pair by name, and a calibration file. Times are the names where all are
  /// nanoseconds of 16 digits or more or decimal seconds, else the pairs count as 10 a second.
  kPlain,
};

struct DatasetOptions {
  std::optional<DatasetFormat> format;  ///< Recognised where absent.
  /// A file, or a folder with one, that ReadCalibration reads: needed by kPlain, in place of
  /// sensor.yaml for kEuroc, an Error for KITTI.
  std::optional<std::filesystem::path> calibration;
  /// The second file of a calibration that is in two.
  std::optional<std::filesystem::path> calibration_mate;
  std::optional<std::filesystem::path> groundtruth;  ///< Found where the format says, if absent.
  /// Frames start, start + stride, ... at most count of them (-1: all).
  int start = 0;
  int count = -1;
  int stride = 1;
  void Validate() const;
};

/// A stereo sequence on disk: opened (listed, calibrated, checked for missing files), not loaded.
struct Dataset {
  struct Entry {
    int64_t timestamp_ns = 0;
    std::array<std::filesystem::path, 2> images;
  };

  std::filesystem::path root;
  DatasetFormat format = DatasetFormat::kEuroc;
  StereoRig rig;
  std::filesystem::path calibration;  ///< The file that the rig is from, for messages.
  std::vector<Entry> entries;
  /// What a user should know, a sentence each.
  std::vector<std::string> warnings;
  /// Poses of the rig's body; absent where the data set has none.
  std::optional<Trajectory> groundtruth;

  /// Throws Error naming the image where it cannot be read or has another size than its camera.
  StereoFrame Read(std::size_t index) const;
};

/// Throws Error with one line that names the missing or malformed file.
Dataset OpenDataset(const std::filesystem::path& path, const DatasetOptions& options);

}  // namespace gluevo::vo
