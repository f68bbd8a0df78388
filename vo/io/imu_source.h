#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/io/imu_data.h"
#include "kitti_files.h"

// Where data sets keep the readings of their inertial unit.
namespace gluevo::vo {

/// The table and, where they are there, the calibration files of EuRoC's and TUM-VI's layout.
struct ImuFiles {
  std::filesystem::path table;
  std::vector<std::filesystem::path> calibrations;  ///< The first that is there counts.
};
ImuFiles EurocImuFiles(const std::filesystem::path& mav0);

/// The samples of a table, in order and in the usual units, with what is wrong with them. Throws
/// Error as ParseImuTable does.
ImuData ReadImuTable(const std::filesystem::path& table);

/// Gives a data set, whose rig is there, its inertial data: of options.imu, else of `files` where
/// the table is there. Whatever is wrong with these is `refused`, since nobody asked for them.
/// Throws Error where options.imu or options.imu_calibration cannot be read.
void AddImu(const DatasetOptions& options, const ImuFiles& files, Dataset& dataset);

/// The oxts folder of a KITTI raw drive (Geiger et al. 2013): a file a reading, fields 11 to 13
/// being accelerations (m/s^2) and 17 to 19 turning rates (rad/s), x forward, y left, z up; times
/// count from `origin_ns` since 1970. Throws Error naming the file that is malformed.
ImuData ReadOxts(const std::filesystem::path& oxts, int64_t origin_ns);
/// The first time of a folder's timestamps.txt, nanoseconds since 1970.
int64_t FirstDate(const std::filesystem::path& timestamps);

/// left_from_imu of a drive, whose calib_imu_to_velo.txt and calib_velo_to_cam.txt lie where its
/// calib_cam_to_cam.txt does. `number` is the left camera's, "00" or "02". Throws Error naming the
/// file that is missing or malformed.
Rigid3 LeftFromOxts(const KittiCalibration& cameras, const std::string& number, bool is_rectified);

/// Gives a drive, whose rig is there, its inertial data where it has an oxts folder.
void AddOxts(const std::string& left_number, int64_t origin_ns, Dataset& dataset);

}  // namespace gluevo::vo
