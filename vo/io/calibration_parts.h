#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "calibration_forms.h"

// What several tools' calibrations have in common.
namespace gluevo::vo {

/// Gives a camera the lens of that name ("radtan", "plumb_bob", "rational_polynomial", "fisheye",
/// ...) and its coefficients in the name's order; OpenCV's vectors of 4, 5, 8, 12 and 14 by their
/// length. Throws Error beginning with `where` for another name, number or model.
void SetLens(const std::string& name, const std::vector<double>& coefficients,
             const std::string& where, Camera& camera);

/// Width and height of a camera, pixels. Throws Error for what is no size.
void SetSize(double width, double height, const std::filesystem::path& path, Camera& camera);

/// fx, fy, cx, cy of a 3 x 3 matrix in rows. Throws Error beginning with `where` for nine numbers
/// that are no camera matrix.
void SetMatrix(const std::vector<double>& rows, const std::string& where, Camera& camera);

/// A camera as EuRoC's sensor.yaml and Kalibr's camchain write it: camera_model (pinhole, omni, ds,
/// eucm), intrinsics, resolution, distortion_model, distortion_coefficients or distortion_coeffs.
Camera CameraFromYaml(const YAML::Node& node, const std::filesystem::path& path);

/// A rigid transform under a key, 3 x 4 or 4 x 4. Rounded rotations get a warning.
Rigid3 TransformFromYaml(const YAML::Node& node, const std::string& key,
                         const std::filesystem::path& path, Calibration& calibration);

/// A rotation (9 numbers in rows, or 3 of a rotation vector) and a translation.
Rigid3 TransformFromParts(const std::vector<double>& rotation,
                          const std::vector<double>& translation, const std::string& key,
                          const std::filesystem::path& path, Calibration& calibration);

/// The rectification of one camera: rectified_from_cam in rows and the 3 x 4 projection in rows.
struct Rectification {
  std::vector<double> rotation;
  std::vector<double> projection;
};

/// right_from_left of two cameras that are rectified by these. Throws Error where the projections
/// have no baseline.
Rigid3 RightFromLeft(const std::array<Rectification, 2>& rectifications,
                     const std::array<std::filesystem::path, 2>& paths, Calibration& calibration);

}  // namespace gluevo::vo
