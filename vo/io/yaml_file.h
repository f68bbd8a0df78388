#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::vo {

/// A YAML file, also one with OpenCV's "%YAML:1.0" header. Throws Error with file and line.
YAML::Node ReadYaml(const std::filesystem::path& path);

/// The numbers of a list, or of the `data` of an OpenCV matrix. Throws Error naming file and key
/// where the key is missing or does not hold finite numbers, `count` of them where that is above 0.
std::vector<double> YamlNumbers(const YAML::Node& node, const std::string& key, std::size_t count,
                                const std::filesystem::path& path);

/// The text of a key, nothing where it is missing. Throws Error naming file and key for a list or a
/// map.
std::optional<std::string> YamlText(const YAML::Node& node, const std::string& key,
                                    const std::filesystem::path& path);

/// A width or height, pixels. Throws Error naming file and key unless it is a whole positive
/// number.
int YamlSize(double value, const std::string& key, const std::filesystem::path& path);

/// From 12 or 16 numbers, the rows of [R | t]. Throws Error naming file and key unless it is rigid.
Rigid3 RigidFromRows(const std::vector<double>& numbers, const std::string& key,
                     const std::filesystem::path& path);

/// "radial-tangential", "radtan", "plumb_bob", "equidistant", "fisheye" or "none". Throws Error
/// naming the file for another name.
Distortion DistortionFromName(const std::string& name, const std::filesystem::path& path);

/// A camera's intrinsics as EuRoC's sensor.yaml and Kalibr's camchain write them: intrinsics,
/// resolution, distortion_model, distortion_coefficients or distortion_coeffs.
Camera CameraFromYaml(const YAML::Node& node, const std::filesystem::path& path);

/// Kalibr's camchain of a stereo rig. The body is the IMU where cam0 has T_cam_imu, else the left
/// camera; the right camera follows from its own T_cam_imu or from T_cn_cnm1.
StereoRig RigFromCamchain(const std::filesystem::path& path);

/// What --calibration names: Kalibr's camchain where the file has cam0 or cam1, else the file of
/// OpenCV's stereo calibration, with
///  - image_width and image_height, pixels, or image_size: [width, height],
///  - K1 and K2 (or M1 and M2), 3 x 3,
///  - D1 and D2: k1 k2 p1 p2 [k3], or the four of cv::fisheye with distortion_model: equidistant,
///  - R, 3 x 3, and T, metres, from the left to the right camera, as stereoCalibrate returns them.
/// The body is the left camera then.
StereoRig RigFromCalibration(const std::filesystem::path& path);

}  // namespace gluevo::vo
