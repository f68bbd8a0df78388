// EuRoC's sensor.yaml, one a camera.

#include "calibration_parts.h"

namespace gluevo::vo {
namespace {

bool Is(const CalibrationFile& file) {
  // Its other sensors have T_BS, too.
  return file.Has("T_BS") && (file.Has("intrinsics") || file.Has("resolution"));
}

void Read(const CalibrationInput& input, Calibration& calibration) {
  const std::array<CalibrationFile, 2> files = LeftAndRight(input, &Is, calibration);
  calibration.rig.body_frame = "imu (body)";
  for (std::size_t side = 0; side < 2; ++side) {
    const CalibrationFile& file = files[side];
    calibration.rig.cameras[side] = CameraFromYaml(file.tree, file.path);
    calibration.rig.body_from_cam[side] =
        TransformFromYaml(file.tree, "T_BS", file.path, calibration);
  }
}

}  // namespace

const CalibrationForm kEurocForm = {
    "EuRoC sensor.yaml", "EuRoC sensor.yaml of both cameras (T_BS, intrinsics)", &Is, 2, &Read};

}  // namespace gluevo::vo
