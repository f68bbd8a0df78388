// ROS's sensor_msgs/CameraInfo of both cameras, as camera_calibration writes it (yaml) or as
// rostopic and ros2 topic print it.

#include "calibration_parts.h"
#include "gluevo/nn/error.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

// What a field may be called.
using Names = std::array<const char*, 3>;
constexpr Names kMatrix = {"camera_matrix", "K", "k"};
constexpr Names kCoefficients = {"distortion_coefficients", "D", "d"};
constexpr Names kRotation = {"rectification_matrix", "R", "r"};
constexpr Names kProjection = {"projection_matrix", "P", "p"};
constexpr Names kWidth = {"image_width", "width", "width"};
constexpr Names kHeight = {"image_height", "height", "height"};

const char* Find(const CalibrationFile& file, const Names& names) {
  for (const char* const name : names) {
    if (file.Has(name)) {
      return name;
    }
  }
  return nullptr;
}

bool Is(const CalibrationFile& file) {
  return Find(file, kMatrix) != nullptr && Find(file, kProjection) != nullptr &&
         Find(file, kHeight) != nullptr;
}

std::vector<double> Numbers(const CalibrationFile& file, const Names& names, std::size_t count) {
  const char* const name = Find(file, names);
  return YamlNumbers(file.tree, name != nullptr ? name : names[0], count, file.path);
}

void Read(const CalibrationInput& input, Calibration& calibration) {
  std::array<CalibrationFile, 2> files = LeftAndRight(input, &Is, calibration);
  std::array<Rectification, 2> rectifications;
  std::array<std::filesystem::path, 2> paths;
  for (std::size_t side = 0; side < 2; ++side) {
    const CalibrationFile& file = files[side];
    paths[side] = file.path;
    Camera& camera = calibration.rig.cameras[side];
    SetMatrix(Numbers(file, kMatrix, 9), file.path.string() + ": " + Find(file, kMatrix), camera);
    SetLens(YamlText(file.tree, "distortion_model", file.path).value_or("plumb_bob"),
            Numbers(file, kCoefficients, 0), file.path.string() + ": distortion_coefficients",
            camera);
    SetSize(Numbers(file, kWidth, 1)[0], Numbers(file, kHeight, 1)[0], file.path, camera);
    rectifications[side] = {Numbers(file, kRotation, 9), Numbers(file, kProjection, 12)};
  }
  calibration.rig.body_frame = "left camera";
  calibration.rig.body_from_cam[1] = RightFromLeft(rectifications, paths, calibration).Inverse();
  calibration.notes.emplace_back(
      "for images as the cameras give them (image_raw), not for rectified ones (image_rect)");
}

}  // namespace

const CalibrationForm kRosCameraInfoForm = {
    "ROS camera_info", "ROS camera_info of both cameras (camera_matrix, projection_matrix)", &Is, 2,
    &Read};

}  // namespace gluevo::vo
