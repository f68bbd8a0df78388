#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::vo {

/// What the calibration files of some tool say.
struct Calibration {
  std::string tool;                          ///< Who writes such files: "Kalibr camchain".
  std::vector<std::filesystem::path> files;  ///< All that were read; those that were named first.
  StereoRig rig;  ///< Width and height are 0 where neither the files nor the caller know them.
  double imu_time_shift_s = 0.0;      ///< t_imu = t_image + this; 0 where it says nothing.
  std::vector<std::string> notes;     ///< How it was understood, a sentence each.
  std::vector<std::string> warnings;  ///< What is probably wrong, a sentence each.
};

/// Reads the calibration of a stereo rig from one file, two (of left and right, or intrinsics and
/// extrinsics) or a folder that holds them; which tool wrote it is told by its content. A mate that
/// is not named is looked for beside a file. `image_size` is width and height of the images,
/// pixels: for files that do not have it, and for those that have several. Throws Error that names
/// the file, what is wrong and as what it was read; one that lists the forms for a file that none
/// knows; and StereoRig::Validate's.
Calibration ReadCalibration(const std::vector<std::filesystem::path>& files,
                            const std::optional<std::array<int, 2>>& image_size);

/// The two cameras have no distortion, one focal length and one viewing direction, and the right
/// one is exactly beside the left.
bool IsRectified(const StereoRig& rig);

/// The text of a Kalibr camchain. Throws Error for a lens that Kalibr has no model of.
std::string KalibrText(const StereoRig& rig);
/// The text of EuRoC's sensor.yaml of one camera (0 left, 1 right). Lenses other than EuRoC's
/// radial-tangential and equidistant are named as in Kalibr's camchain.
std::string SensorYamlText(const StereoRig& rig, std::size_t side);

}  // namespace gluevo::vo
