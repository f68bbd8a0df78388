// VINS-Fusion: a configuration that names a camera file of camodocal for each side.

#include <algorithm>
#include <cctype>

#include "calibration_parts.h"
#include "gluevo/nn/error.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

bool IsCamera(const CalibrationFile& file) {
  return file.Has("model_type") &&
         (file.Has("projection_parameters") || file.Has("mirror_parameters"));
}

bool Is(const CalibrationFile& file) {
  return file.Has("cam0_calib") || file.Has("num_of_cam") || IsCamera(file);
}

struct Model {
  std::string_view name;
  Distortion distortion;
  std::array<const char*, 4> intrinsics;  // fx fy cx cy
  const char* lens_group;
  std::vector<const char*> coefficients;
};

const Model& ModelOf(const CalibrationFile& file) {
  static const std::vector<Model> models = {{"PINHOLE",
                                             Distortion::kRadialTangential,
                                             {"fx", "fy", "cx", "cy"},
                                             "distortion_parameters",
                                             {"k1", "k2", "p1", "p2"}},
                                            {"PINHOLE_FULL",
                                             Distortion::kRational,
                                             {"fx", "fy", "cx", "cy"},
                                             "distortion_parameters",
                                             {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}},
                                            {"MEI",
                                             Distortion::kMei,
                                             {"gamma1", "gamma2", "u0", "v0"},
                                             "distortion_parameters",
                                             {"k1", "k2", "p1", "p2"}},
                                            {"KANNALA_BRANDT",
                                             Distortion::kEquidistant,
                                             {"mu", "mv", "u0", "v0"},
                                             "projection_parameters",
                                             {"k2", "k3", "k4", "k5"}}};
  std::string name = YamlText(file.tree, "model_type", file.path).value_or("");
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  const auto found = std::find_if(models.begin(), models.end(),
                                  [&](const Model& model) { return model.name == name; });
  if (found == models.end()) {
    throw Error(file.path.string() + ": model_type " + name +
                " is not supported, expected PINHOLE, PINHOLE_FULL, MEI or KANNALA_BRANDT");
  }
  return *found;
}

// Parameters are each under a name in a group.
double Parameter(const CalibrationFile& file, const std::string& group, const std::string& name) {
  const YAML::Node node = file.tree[group];
  if (!node || !node.IsMap()) {
    throw Error(file.path.string() + ": no " + group);
  }
  return YamlNumbers(node, name, 1, file.path)[0];
}

Camera ReadCamera(const CalibrationFile& file) {
  const Model& model = ModelOf(file);
  const auto projection = [&](std::size_t i) {
    return Parameter(file, "projection_parameters", model.intrinsics[i]);
  };
  Camera camera;
  camera.fx = projection(0);
  camera.fy = projection(1);
  camera.cx = projection(2);
  camera.cy = projection(3);
  if (file.Has("image_width") && file.Has("image_height")) {
    SetSize(YamlNumbers(file.tree, "image_width", 1, file.path)[0],
            YamlNumbers(file.tree, "image_height", 1, file.path)[0], file.path, camera);
  }
  std::size_t count = 0;
  camera.distortion = model.distortion;
  if (model.distortion == Distortion::kMei) {
    camera.coefficients[count++] = Parameter(file, "mirror_parameters", "xi");
  }
  const bool has_lens = file.Has(model.lens_group) && file.tree[model.lens_group].IsMap();
  for (const char* const name : model.coefficients) {
    const bool is_there = has_lens && file.tree[model.lens_group][name].IsDefined();
    camera.coefficients[count++] = is_there ? Parameter(file, model.lens_group, name) : 0.0;
  }
  return camera;
}

void Read(const CalibrationInput& input, Calibration& calibration) {
  const CalibrationFile& config = input.named[0];
  const fs::path& path = config.path;
  if (IsCamera(config) && !config.Has("cam0_calib")) {
    throw Error(path.string() +
                ": a camera file alone, expected the configuration that names it (cam0_calib, "
                "cam1_calib, body_T_cam0, body_T_cam1)");
  }
  calibration.rig.body_frame = "imu (body)";
  if (config.Has("td")) {
    calibration.imu_time_shift_s = YamlNumbers(config.tree, "td", 1, path)[0];
  }
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string number = std::to_string(side);
    const std::string key = "cam" + number + "_calib";
    const std::optional<std::string> name = YamlText(config.tree, key, path);
    if (!name) {
      throw Error(path.string() + ": no " + key + ", expected two cameras");
    }
    const std::string pose = "body_T_cam" + number;
    if (!config.Has(pose)) {
      throw Error(path.string() + ": no " + pose + ", expected the extrinsics of both cameras");
    }
    calibration.rig.cameras[side] =
        ReadCamera(OpenBeside(input, path.parent_path() / *name, path, calibration));
    calibration.rig.body_from_cam[side] = TransformFromYaml(config.tree, pose, path, calibration);
  }
}

}  // namespace

const CalibrationForm kVinsFusionForm = {"VINS-Fusion configuration",
                                         "VINS-Fusion configuration (cam0_calib, body_T_cam0)", &Is,
                                         1, &Read};

}  // namespace gluevo::vo
