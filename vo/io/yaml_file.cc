#include "yaml_file.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "gluevo/nn/error.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

}  // namespace

YAML::Node ReadYaml(const fs::path& path) {
  std::string text = ReadText(path);
  // OpenCV's header is no YAML directive: read as a comment, it does no harm.
  if (text.starts_with("%YAML:")) {
    text.front() = '#';
  }
  try {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap()) {
      throw Error(path.string() + ": expected a YAML map");
    }
    return root;
  } catch (const YAML::Exception& error) {
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
    const std::optional<double> number =
        item.IsScalar() ? ParseNumber(item.Scalar()) : std::nullopt;
    if (!number) {
      throw Error(path.string() + ": " + key + " is not a list of finite numbers");
    }
    numbers.push_back(*number);
  };
  add(add, list);
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
  const std::array<double, 4> last_row = {0.0, 0.0, 0.0, 1.0};
  if (numbers.size() == 16 && !std::equal(last_row.begin(), last_row.end(), numbers.begin() + 12)) {
    throw Error(path.string() + ": the last row of " + key + " is not 0 0 0 1");
  }
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(numbers.data());
  const Eigen::Matrix3d rotation = matrix.leftCols<3>();
  if ((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-3 ||
      !(rotation.determinant() > 0.0)) {
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

std::optional<std::string> YamlText(const YAML::Node& node, const std::string& key,
                                    const fs::path& path) {
  const YAML::Node text = node[key];
  if (!text) {
    return std::nullopt;
  }
  if (!text.IsScalar()) {
    throw Error(path.string() + ": " + key + " is not a name");
  }
  return text.Scalar();
}

int YamlSize(double value, const std::string& key, const fs::path& path) {
  constexpr double kLargest = 1 << 20;
  if (!(value >= 1.0 && value <= kLargest) || value != std::floor(value)) {
    throw Error(path.string() + ": " + key + " is no size of an image in pixels");
  }
  return static_cast<int>(value);
}

Camera CameraFromYaml(const YAML::Node& node, const fs::path& path) {
  const std::optional<std::string> model = YamlText(node, "camera_model", path);
  if (model && *model != "pinhole") {
    throw Error(path.string() + ": camera model " + Quoted(*model) +
                " is not supported, expected pinhole");
  }
  const std::vector<double> resolution = YamlNumbers(node, "resolution", 2, path);
  const int width = YamlSize(resolution[0], "resolution", path);
  const int height = YamlSize(resolution[1], "resolution", path);
  const std::vector<double> k = YamlNumbers(node, "intrinsics", 4, path);
  Camera camera = {width, height, /*fx=*/k[0], /*fy=*/k[1], /*cx=*/k[2], /*cy=*/k[3]};
  const std::optional<std::string> distortion = YamlText(node, "distortion_model", path);
  if (!distortion) {
    throw Error(path.string() + ": no distortion_model");
  }
  camera.distortion = DistortionFromName(*distortion, path);
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

namespace {

StereoRig RigFromOpenCv(const YAML::Node& root, const fs::path& path) {
  StereoRig rig;
  rig.body_frame = "left camera";
  const std::vector<double> size =
      root["image_size"] ? YamlNumbers(root, "image_size", 2, path)
                         : std::vector<double>{YamlNumbers(root, "image_width", 1, path)[0],
                                               YamlNumbers(root, "image_height", 1, path)[0]};
  const std::optional<std::string> model = YamlText(root, "distortion_model", path);
  const Distortion distortion =
      model ? DistortionFromName(*model, path) : Distortion::kRadialTangential;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string number = side == 0 ? "1" : "2";
    const std::vector<double> k =
        YamlNumbers(root, (root["M" + number] ? "M" : "K") + number, 9, path);
    Camera& camera = rig.cameras[side];
    const int width = YamlSize(size[0], "the image width", path);
    const int height = YamlSize(size[1], "the image height", path);
    camera = {width, height, /*fx=*/k[0], /*fy=*/k[4], /*cx=*/k[2], /*cy=*/k[5]};
    camera.distortion = distortion;
    if (distortion != Distortion::kNone) {
      const std::vector<double> d = YamlNumbers(root, "D" + number, 0, path);
      const std::size_t most = distortion == Distortion::kEquidistant ? 4 : 5;
      // OpenCV writes the terms of its larger models, which are zero unless asked for.
      const bool larger_model = std::any_of(d.begin() + std::min(d.size(), most), d.end(),
                                            [](double value) { return value != 0.0; });
      if (d.size() < 4 || larger_model) {
        throw Error(path.string() + ": D" + number + " has " + std::to_string(d.size()) +
                    " coefficients, expected " + (most == 4 ? "k1 k2 k3 k4" : "k1 k2 p1 p2 [k3]"));
      }
      std::copy_n(d.begin(), std::min(d.size(), most), camera.coefficients.begin());
    }
    camera.Validate(path.string() + ": camera " + number);
  }
  const std::vector<double> r = YamlNumbers(root, "R", 9, path);
  const std::vector<double> t = YamlNumbers(root, "T", 3, path);
  rig.body_from_cam[1] =
      RigidFromRows({r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2]}, "R",
                    path)
          .Inverse();
  // Calibration boards are often measured in millimetres, and T comes out in them.
  constexpr double kLongestBaseline = 10.0;
  if (rig.baseline() > kLongestBaseline) {
    throw Error(path.string() + ": T has a length of " + std::to_string(rig.baseline()) +
                ", expected metres, at most 10");
  }
  return rig;
}

}  // namespace

StereoRig RigFromCalibration(const fs::path& path) {
  const YAML::Node root = ReadYaml(path);
  return root["cam0"] || root["cam1"] ? RigFromCamchain(path) : RigFromOpenCv(root, path);
}

}  // namespace gluevo::vo
