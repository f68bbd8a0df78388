#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>
#include <vector>

#include "gluevo/vo/camera.h"

namespace gluevo::vo {

/// A YAML file, also one with OpenCV's "%YAML:1.0" header. Throws Error with file and line.
YAML::Node ReadYaml(const std::filesystem::path& path);

/// The numbers of a list, or of the `data` of an OpenCV matrix. Throws Error naming file and key
/// where the key is missing or does not hold finite numbers, `count` of them where that is above 0.
std::vector<double> YamlNumbers(const YAML::Node& node, const std::string& key, std::size_t count,
                                const std::filesystem::path& path);

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

}  // namespace gluevo::vo
