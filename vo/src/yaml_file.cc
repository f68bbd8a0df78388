#include "yaml_file.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

}  // namespace

YAML::Node ReadYaml(const fs::path& path) {
  std::ifstream file(path);
  if (!file || fs::is_directory(path)) {
    throw Error(path.string() + ": cannot be read");
  }
  std::ostringstream text;
  std::string line;
  while (std::getline(file, line)) {
    // OpenCV's header is no YAML directive; an empty line in its place keeps the line numbers.
    text << (line.starts_with("%YAML:") ? "" : line) << '\n';
  }
  try {
    const YAML::Node root = YAML::Load(text.str());
    if (!root.IsMap()) {
      throw Error(path.string() + ": expected a YAML map");
    }
    return root;
  } catch (const YAML::ParserException& error) {
    throw Error(path.string() + ":" + std::to_string(error.mark.line + 1) +
                ": not YAML: " + error.msg);
  }
}

std::vector<double> YamlNumbers(const YAML::Node& node, const std::string& key, std::size_t count,
                                const fs::path& path) {
  YAML::Node list = node[key];
  if (!list) {
    throw Error(path.string() + ": no " + key);
  }
  if (list.IsMap()) {
    list.reset(list["data"]);
  }
  std::vector<double> numbers;
  const auto add = [&](const auto& self, const YAML::Node& item) -> void {
    if (item.IsSequence()) {
      for (const YAML::Node& inner : item) {
        self(self, inner);
      }
      return;
    }
    try {
      numbers.push_back(item.as<double>());
    } catch (const YAML::Exception&) {
      throw Error(path.string() + ": " + key + " is not a list of numbers");
    }
  };
  add(add, list);
  if (!std::all_of(numbers.begin(), numbers.end(), [](double v) { return std::isfinite(v); })) {
    throw Error(path.string() + ": " + key + " holds a number that is not finite");
  }
  if (count > 0 && numbers.size() != count) {
    throw Error(path.string() + ": " + key + " has " + std::to_string(numbers.size()) +
                " numbers, expected " + std::to_string(count));
  }
  return numbers;
}

Rigid3 RigidFromRows(const std::vector<double>& numbers, const std::string& key,
                     const fs::path& path) {
  if (numbers.size() != 12 && numbers.size() != 16) {
    throw Error(path.string() + ": " + key + " has " + std::to_string(numbers.size()) +
                " numbers, expected a 4 x 4 matrix");
  }
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(numbers.data());
  const Eigen::Matrix3d rotation = matrix.leftCols<3>();
  if ((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-3 ||
      rotation.determinant() < 0.0) {
    throw Error(path.string() + ": " + key + " is not a rigid transform");
  }
  return {Eigen::Quaterniond(rotation).normalized(), matrix.col(3)};
}

Distortion DistortionFromName(const std::string& name, const fs::path& path) {
  if (name == "radial-tangential" || name == "radtan" || name == "plumb_bob") {
    return Distortion::kRadialTangential;
  }
  if (name == "equidistant" || name == "equi" || name == "fisheye") {
    return Distortion::kEquidistant;
  }
  if (name == "none") {
    return Distortion::kNone;
  }
  throw Error(path.string() + ": distortion model " + Quoted(name) +
              " is not known, expected radial-tangential, radtan, equidistant or none");
}

Camera CameraFromYaml(const YAML::Node& node, const fs::path& path) {
  if (node["camera_model"]) {
    const auto model = node["camera_model"].as<std::string>();
    if (model != "pinhole") {
      throw Error(path.string() + ": camera model " + Quoted(model) +
                  " is not supported, expected pinhole");
    }
  }
  Camera camera;
  const std::vector<double> resolution = YamlNumbers(node, "resolution", 2, path);
  camera.width = static_cast<int>(resolution[0]);
  camera.height = static_cast<int>(resolution[1]);
  const std::vector<double> intrinsics = YamlNumbers(node, "intrinsics", 4, path);
  camera.fx = intrinsics[0];
  camera.fy = intrinsics[1];
  camera.cx = intrinsics[2];
  camera.cy = intrinsics[3];
  if (!node["distortion_model"]) {
    throw Error(path.string() + ": no distortion_model");
  }
  camera.distortion = DistortionFromName(node["distortion_model"].as<std::string>(), path);
  if (camera.distortion != Distortion::kNone) {
    const char* const key =
        node["distortion_coefficients"] ? "distortion_coefficients" : "distortion_coeffs";
    const std::vector<double> coefficients = YamlNumbers(node, key, 0, path);
    const std::size_t most = camera.distortion == Distortion::kEquidistant ? 4 : 5;
    if (coefficients.size() < 4 || coefficients.size() > most) {
      throw Error(path.string() + ": " + key + " has " + std::to_string(coefficients.size()) +
                  " numbers, expected " + (most == 4 ? "4" : "4 or 5"));
    }
    std::copy(coefficients.begin(), coefficients.end(), camera.coefficients.begin());
  }
  camera.Validate(path.string());
  return camera;
}

StereoRig RigFromCamchain(const fs::path& path) {
  const YAML::Node root = ReadYaml(path);
  for (const char* const name : {"cam0", "cam1"}) {
    if (!root[name] || !root[name].IsMap()) {
      throw Error(path.string() + ": no " + name + ", expected Kalibr's cam0 and cam1");
    }
  }
  StereoRig rig;
  rig.cameras = {CameraFromYaml(root["cam0"], path), CameraFromYaml(root["cam1"], path)};
  const auto transform = [&](const YAML::Node& node, const char* key) {
    return RigidFromRows(YamlNumbers(node, key, 0, path), key, path);
  };
  const bool has_imu = static_cast<bool>(root["cam0"]["T_cam_imu"]);
  rig.body_frame = has_imu ? "imu (body)" : "left camera";
  if (has_imu) {
    rig.body_from_cam[0] = transform(root["cam0"], "T_cam_imu").Inverse();
  }
  if (root["cam1"]["T_cn_cnm1"]) {
    rig.body_from_cam[1] = rig.body_from_cam[0] * transform(root["cam1"], "T_cn_cnm1").Inverse();
  } else if (has_imu) {
    rig.body_from_cam[1] = transform(root["cam1"], "T_cam_imu").Inverse();
  } else {
    throw Error(path.string() + ": cam1 has no T_cn_cnm1, the transform from cam0");
  }
  return rig;
}

}  // namespace gluevo::vo
