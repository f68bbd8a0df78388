// Stereo settings of ORB-SLAM2 and ORB-SLAM3.

#include "calibration_parts.h"
#include "gluevo/nn/error.h"
#include "text_file.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

bool Is(const CalibrationFile& file) {
  return file.Has("LEFT.K") || file.Has("RIGHT.K") || file.Has("Camera.fx") ||
         file.Has("Camera1.fx");
}

double Number(const CalibrationFile& file, const std::string& key) {
  return YamlNumbers(file.tree, key, 1, file.path)[0];
}

// Fisheye, rectified or pinhole, whatever the case of its letters.
std::string TypeOf(const CalibrationFile& file) {
  return Lowercase(YamlText(file.tree, "Camera.type", file.path).value_or("pinhole"));
}

Camera ReadCamera(const CalibrationFile& file, const std::string& prefix) {
  Camera camera;
  camera.fx = Number(file, prefix + ".fx");
  camera.fy = Number(file, prefix + ".fy");
  camera.cx = Number(file, prefix + ".cx");
  camera.cy = Number(file, prefix + ".cy");
  const bool fisheye = TypeOf(file) == "kannalabrandt8";
  const std::vector<const char*> names =
      fisheye ? std::vector<const char*>{".k1", ".k2", ".k3", ".k4"}
              : std::vector<const char*>{".k1", ".k2", ".p1", ".p2", ".k3"};
  std::vector<double> coefficients;
  for (const char* const name : names) {
    coefficients.push_back(file.Has(prefix + name) ? Number(file, prefix + name) : 0.0);
  }
  SetLens(fisheye ? "equidistant" : "radtan", coefficients, file.path.string() + ": " + prefix,
          camera);
  if (!fisheye && std::all_of(coefficients.begin(), coefficients.end(),
                              [](double value) { return value == 0.0; })) {
    camera.distortion = Distortion::kNone;
  }
  return camera;
}

// Unrectified images, and how ORB-SLAM rectifies them.
void ReadUnrectified(const CalibrationFile& file, Calibration& calibration) {
  std::array<Rectification, 2> rectifications;
  constexpr std::array<const char*, 2> kSides = {"LEFT", "RIGHT"};
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string prefix = kSides[side];
    Camera& camera = calibration.rig.cameras[side];
    SetMatrix(YamlNumbers(file.tree, prefix + ".K", 9, file.path),
              file.path.string() + ": " + prefix + ".K", camera);
    SetLens("radtan", YamlNumbers(file.tree, prefix + ".D", 0, file.path),
            file.path.string() + ": " + prefix + ".D", camera);
    if (file.Has(prefix + ".width") && file.Has(prefix + ".height")) {
      SetSize(Number(file, prefix + ".width"), Number(file, prefix + ".height"), file.path, camera);
    }
    rectifications[side] = {YamlNumbers(file.tree, prefix + ".R", 9, file.path),
                            YamlNumbers(file.tree, prefix + ".P", 12, file.path)};
  }
  const Rigid3 right_from_left = RightFromLeft(rectifications, {file.path, file.path}, calibration);
  calibration.rig.body_from_cam[1] = right_from_left.Inverse();
  calibration.notes.emplace_back("for images that are not rectified (LEFT.K, RIGHT.K)");
}

// The pose of the second camera, in either version.
Rigid3 LeftFromRight(const CalibrationFile& file, Calibration& calibration) {
  for (const char* const key : {"Stereo.T_c1_c2", "Tlr"}) {
    if (file.Has(key)) {
      return TransformFromYaml(file.tree, key, file.path, calibration);
    }
  }
  throw Error(
      file.path.string() +
      ": one camera only, or no transform between two: expected Camera2 with Stereo.T_c1_c2 "
      "(or Tlr), LEFT.K and RIGHT.K, Camera.bf or Stereo.b");
}

// Rectified images: one camera, beside itself.
void SetRectified(const Camera& camera, double baseline, Calibration& calibration) {
  calibration.rig.cameras.fill(camera);
  calibration.rig.body_from_cam[1].translation = Eigen::Vector3d(baseline, 0.0, 0.0);
  calibration.notes.emplace_back("for rectified images");
}

void ReadCameras(const CalibrationFile& file, Calibration& calibration) {
  const std::string first = file.Has("Camera1.fx") ? "Camera1" : "Camera";
  const Camera left = ReadCamera(file, first);
  if (file.Has("Camera2.fx")) {
    calibration.rig.cameras = {left, ReadCamera(file, "Camera2")};
    calibration.rig.body_from_cam[1] = LeftFromRight(file, calibration);
  } else if (file.Has("Stereo.b")) {
    SetRectified(left, Number(file, "Stereo.b"), calibration);
  } else if (file.Has("Camera.bf")) {
    SetRectified(left, Number(file, "Camera.bf") / left.fx, calibration);
  } else {
    LeftFromRight(file, calibration);
    throw Error(file.path.string() + ": no Camera2.fx, expected two cameras");
  }
}

// Where there is an IMU, trajectories are of it.
void SetBody(const CalibrationFile& file, Calibration& calibration) {
  StereoRig& rig = calibration.rig;
  rig.body_frame = "left camera";
  for (const char* const key : {"IMU.T_b_c1", "Tbc"}) {
    if (file.Has(key)) {
      const Rigid3 body_from_left = TransformFromYaml(file.tree, key, file.path, calibration);
      rig.body_from_cam = {body_from_left, body_from_left * rig.body_from_cam[1]};
      rig.body_frame = "imu (body)";
      return;
    }
  }
}

void Read(const CalibrationInput& input, Calibration& calibration) {
  const CalibrationFile& file = input.named[0];
  if (file.Has("LEFT.K") || file.Has("RIGHT.K")) {
    ReadUnrectified(file, calibration);
  } else {
    ReadCameras(file, calibration);
  }
  if (file.Has("Camera.width") && file.Has("Camera.height")) {
    for (Camera& camera : calibration.rig.cameras) {
      if (camera.width == 0) {
        SetSize(Number(file, "Camera.width"), Number(file, "Camera.height"), file.path, camera);
      }
    }
  }
  SetBody(file, calibration);
}

}  // namespace

const CalibrationForm kOrbSlamForm = {
    "ORB-SLAM settings",
    "ORB-SLAM2 or ORB-SLAM3 stereo settings (LEFT.K, Camera1.fx, Camera.fx and Camera.bf)", &Is, 1,
    &Read};

}  // namespace gluevo::vo
