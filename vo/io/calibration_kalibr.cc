// Kalibr's camchain, with or without an IMU, and OpenVINS' form of it (T_imu_cam).

#include <cmath>

#include "calibration_parts.h"
#include "gluevo/nn/error.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

bool Is(const CalibrationFile& file) {
  return (file.Has("cam0") && file.tree["cam0"].IsMap()) ||
         (file.Has("cam1") && file.tree["cam1"].IsMap());
}

// body_from_cam of one camera, where the file has it in either direction.
std::optional<Rigid3> BodyFromCam(const YAML::Node& camera, const fs::path& path,
                                  Calibration& calibration) {
  if (camera["T_imu_cam"]) {
    return TransformFromYaml(camera, "T_imu_cam", path, calibration);
  }
  if (camera["T_cam_imu"]) {
    return TransformFromYaml(camera, "T_cam_imu", path, calibration).Inverse();
  }
  return std::nullopt;
}

// Both ways to the right camera should agree.
void CompareTransforms(const Rigid3& by_chain, const Rigid3& by_imu, Calibration& calibration) {
  constexpr double kApart = 0.01;         // metres
  constexpr double kApartAngle = 0.0175;  // radians, a degree
  if ((by_chain.translation - by_imu.translation).norm() > kApart ||
      by_chain.rotation.angularDistance(by_imu.rotation) > kApartAngle) {
    calibration.warnings.emplace_back(
        "T_cn_cnm1 and the cameras' transforms to the IMU disagree on where the right camera is: "
        "is "
        "one of them inverted? T_cn_cnm1 is taken");
  }
}

// Of the left camera, whose times the pairs have.
void ReadTimeShift(const YAML::Node& left, const YAML::Node& right, const fs::path& path,
                   Calibration& calibration) {
  const std::string key = "timeshift_cam_imu";
  constexpr double kApart = 1e-3;  // seconds
  if (!left[key]) {
    return;
  }
  calibration.imu_time_shift_s = YamlNumbers(left, key, 1, path)[0];
  if (right[key] &&
      std::abs(YamlNumbers(right, key, 1, path)[0] - calibration.imu_time_shift_s) > kApart) {
    calibration.warnings.emplace_back(
        "timeshift_cam_imu of both cameras differ by more than 1 ms: that of cam0 is taken");
  }
}

void ReadChain(const CalibrationFile& file, Calibration& calibration) {
  const fs::path& path = file.path;
  for (const char* const name : {"cam0", "cam1"}) {
    if (!file.Has(name) || !file.tree[name].IsMap()) {
      throw Error(path.string() + ": no " + name + ", expected Kalibr's cam0 and cam1");
    }
  }
  const YAML::Node left = file.tree["cam0"];
  const YAML::Node right = file.tree["cam1"];
  StereoRig& rig = calibration.rig;
  rig.cameras = {CameraFromYaml(left, path), CameraFromYaml(right, path)};
  const std::optional<Rigid3> body_from_left = BodyFromCam(left, path, calibration);
  const std::optional<Rigid3> body_from_right = BodyFromCam(right, path, calibration);
  rig.body_frame = body_from_left ? "imu (body)" : "left camera";
  rig.body_from_cam[0] = body_from_left.value_or(Rigid3());
  if (right["T_cn_cnm1"]) {
    const Rigid3 left_from_right =
        TransformFromYaml(right, "T_cn_cnm1", path, calibration).Inverse();
    rig.body_from_cam[1] = rig.body_from_cam[0] * left_from_right;
    if (body_from_left && body_from_right) {
      CompareTransforms(left_from_right, body_from_left->Inverse() * *body_from_right, calibration);
    }
  } else if (body_from_left && body_from_right) {
    rig.body_from_cam[1] = *body_from_right;
  } else {
    throw Error(
        path.string() +
        ": cam1 has no T_cn_cnm1, the transform from cam0, and the cameras have no T_cam_imu "
        "or T_imu_cam");
  }
  ReadTimeShift(left, right, path, calibration);
  if (file.Has("cam2")) {
    calibration.notes.emplace_back(
        "cam0 is taken as left, cam1 as right; other cameras are not read");
  }
}

void Read(const CalibrationInput& input, Calibration& calibration) {
  if (input.named[0].Has("cam0") && input.named[0].tree["cam0"]["T_imu_cam"]) {
    calibration.tool = "OpenVINS camchain";
  }
  ReadChain(input.named[0], calibration);
}

bool IsOpenVins(const CalibrationFile& file) { return file.Has("relative_config_imucam"); }

// OpenVINS' settings name the chain.
void ReadOpenVins(const CalibrationInput& input, Calibration& calibration) {
  const CalibrationFile& settings = input.named[0];
  const YAML::Node name = settings.tree["relative_config_imucam"];
  if (!name.IsScalar()) {
    throw Error(settings.path.string() + ": relative_config_imucam is not a file name");
  }
  const fs::path chain = settings.path.parent_path() / name.Scalar();
  ReadChain(OpenBeside(input, chain, settings.path, calibration), calibration);
}

}  // namespace

const CalibrationForm kKalibrForm = {"Kalibr camchain",
                                     "Kalibr camchain (cam0, cam1; OpenVINS' with T_imu_cam, too)",
                                     &Is, 1, &Read};
const CalibrationForm kOpenVinsForm = {"OpenVINS settings",
                                       "OpenVINS estimator_config.yaml (relative_config_imucam)",
                                       &IsOpenVins, 1, &ReadOpenVins};

}  // namespace gluevo::vo
