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
#include "gluevo/vo/io/imu_data.h"

namespace gluevo::vo {

enum class DatasetFormat {
  kEuroc,          ///< EuRoC ASL and TUM-VI: mav0/cam0, mav0/cam1.
  kKittiOdometry,  ///< image_0, image_1 (or image_2, image_3), calib.txt, times.txt.
  /// image_00/data, image_01/data (or 02 and 03; KITTI-360: data_rect), image_00/timestamps.txt,
  /// calib_cam_to_cam.txt or perspective.txt here or up to three folders above. Times count from
  /// the first row of timestamps.txt.
  kKittiRaw,
  /// Two folders of images (left and right, cam0 and cam1, ...), or one whose names tell left from
  /// right, and a calibration file. Images pair by their times or numbers. Times are the names or
  /// those of a times file, else numbers count as DatasetOptions::rate_hz a second.
  kPlain,
};

struct DatasetOptions {
  std::optional<DatasetFormat> format;  ///< Recognised where absent.
  /// A file, or a folder with one, that ReadCalibration reads: needed by kPlain, in place of
  /// sensor.yaml for kEuroc, an Error for KITTI.
  std::optional<std::filesystem::path> calibration;
  /// The second file of a calibration that is in two.
  std::optional<std::filesystem::path> calibration_mate;
  /// Readings of an inertial unit: a table, t wx wy wz ax ay az a row or columns with names, for
  /// kPlain and in place of imu0/data.csv for kEuroc; an Error for KITTI.
  std::optional<std::filesystem::path> imu;
  /// Its noise, which ReadImuCalibration reads; in place of imu0/sensor.yaml for kEuroc.
  std::optional<std::filesystem::path> imu_calibration;
  std::optional<std::filesystem::path> groundtruth;  ///< Found where the format says, if absent.
  /// Images a second where a plain data set has no times; 10 where absent, with a warning.
  std::optional<double> rate_hz;
  /// How far the stamps of left and right image may be apart, seconds; a tenth of the time from
  /// image to image where absent. KITTI's pair by number.
  std::optional<double> pair_tolerance_s;
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
  /// Poses of the rig's body; absent where the data set has none.
  std::optional<Trajectory> groundtruth;
  /// What the inertial unit read, `refused` where that cannot be used; absent where there is none.
  std::optional<ImuData> imu;
  /// What the calibration says of the clocks: t_imu = t_image + imu_time_shift_s.
  double imu_time_shift_s = 0.0;
  /// Bits that the gray values of 16-bit files use, the same for all images (image_file.h).
  int gray_bits = 16;
  /// Images of either camera that are in no entry: without a mate, or named in a list and missing.
  int images_left_out = 0;
  /// What a user should know, a sentence each: images left out, times that are assumed,
  /// doubts about the calibration.
  std::vector<std::string> warnings;
  /// How the data set was understood where there was a choice, a sentence each.
  std::vector<std::string> notes;

  /// Throws Error naming the image where it cannot be read or has another size than its camera.
  StereoFrame Read(std::size_t index) const;
};

/// Makes the place of the inertial unit the rig's body, whose axes stay: `rig`, `groundtruth` and
/// `imu` follow. Nothing changes where it is that, or there is none.
void PutBodyAtImu(Dataset& dataset);

/// Throws Error with one line that names the missing or malformed file.
Dataset OpenDataset(const std::filesystem::path& path, const DatasetOptions& options);

}  // namespace gluevo::vo
