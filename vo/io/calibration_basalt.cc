// Basalt's calibration.json: all under "value0".

#include "calibration_parts.h"
#include "gluevo/nn/error.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

bool Is(const CalibrationFile& file) {
  return file.Has("value0") && file.tree["value0"].IsMap() && file.tree["value0"]["intrinsics"];
}

struct Type {
  std::string_view name;
  Distortion distortion;
};

constexpr Type kTypes[] = {
    {"pinhole", Distortion::kNone},         {"pinhole-radtan8", Distortion::kRational},
    {"kb4", Distortion::kEquidistant},      {"ds", Distortion::kDoubleSphere},
    {"eucm", Distortion::kExtendedUnified}, {"ucm", Distortion::kExtendedUnified},
    {"fov", Distortion::kFieldOfView}};

double Number(const YAML::Node& node, const std::string& key, const fs::path& path) {
  return YamlNumbers(node, key, 1, path)[0];
}

Camera ReadCamera(const YAML::Node& node, const fs::path& path) {
  const std::string name = YamlText(node, "camera_type", path).value_or("");
  const Type* found = nullptr;
  for (const Type& type : kTypes) {
    found = type.name == name ? &type : found;
  }
  if (found == nullptr) {
    throw Error(
        path.string() + ": camera_type \"" + name +
        "\" is not supported, expected pinhole, pinhole-radtan8, kb4, ds, eucm, ucm or fov");
  }
  const YAML::Node k = node["intrinsics"];
  if (!k || !k.IsMap()) {
    throw Error(path.string() + ": no intrinsics of a camera");
  }
  Camera camera;
  camera.fx = Number(k, "fx", path);
  camera.fy = Number(k, "fy", path);
  camera.cx = Number(k, "cx", path);
  camera.cy = Number(k, "cy", path);
  if (found->distortion == Distortion::kRational) {
    std::vector<double> d;
    for (const std::string_view key : CoefficientNames(Distortion::kRational)) {
      d.push_back(Number(k, std::string(key), path));
    }
    SetLens("radtan8", d, path.string() + ": intrinsics", camera);
    return camera;
  }
  camera.distortion = found->distortion;
  std::size_t count = 0;
  for (const std::string_view key : CoefficientNames(found->distortion)) {
    // The unified model is the extended one with beta 1.
    camera.coefficients[count++] =
        name == "ucm" && key == "beta" ? 1.0 : Number(k, std::string(key), path);
  }
  return camera;
}

void Read(const CalibrationInput& input, Calibration& calibration) {
  const fs::path& path = input.named[0].path;
  const YAML::Node root = input.named[0].tree["value0"];
  const YAML::Node poses = root["T_imu_cam"];
  const YAML::Node cameras = root["intrinsics"];
  const YAML::Node sizes = root["resolution"];
  constexpr std::size_t kMostCameras = 100;
  if (!poses || !poses.IsSequence() || !cameras.IsSequence() || poses.size() < 2 ||
      cameras.size() < 2 || poses.size() > kMostCameras || cameras.size() > kMostCameras) {
    throw Error(path.string() + ": expected T_imu_cam and intrinsics of two cameras");
  }
  // The file has no camera without an IMU; what lies beside it is mostly told of the left camera.
  calibration.rig.body_frame = "left camera";
  std::array<Rigid3, 2> imu_from_cam;
  for (std::size_t side = 0; side < 2; ++side) {
    const YAML::Node pose = poses[side];
    const YAML::Node node = cameras[side];
    if (!pose.IsMap() || !node.IsMap()) {
      throw Error(path.string() + ": T_imu_cam or intrinsics is not a list of maps");
    }
    Camera& camera = calibration.rig.cameras[side];
    camera = ReadCamera(node, path);
    if (sizes && sizes.IsSequence() && sizes.size() > side) {
      const YAML::Node size = sizes[side];
      if (!size.IsSequence() || size.size() != 2) {
        throw Error(path.string() + ": resolution is not a list of widths and heights");
      }
      SetSize(size[0].as<double>(), size[1].as<double>(), path, camera);
    }
    const Eigen::Quaterniond q(Number(pose, "qw", path), Number(pose, "qx", path),
                               Number(pose, "qy", path), Number(pose, "qz", path));
    constexpr double kAccepted = 0.01;
    if (!(std::abs(q.norm() - 1.0) < kAccepted)) {
      throw Error(path.string() + ": T_imu_cam has a quaternion that is not of length 1");
    }
    imu_from_cam[side] = {q.normalized(),
                          Eigen::Vector3d(Number(pose, "px", path), Number(pose, "py", path),
                                          Number(pose, "pz", path))};
  }
  calibration.rig.body_from_cam[1] = imu_from_cam[0].Inverse() * imu_from_cam[1];
}

}  // namespace

const CalibrationForm kBasaltForm = {
    "Basalt calibration", "Basalt calibration.json (value0: T_imu_cam, intrinsics)", &Is, 1, &Read};

}  // namespace gluevo::vo
