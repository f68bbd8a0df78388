// Noise and mounting of an inertial unit, as several tools write them.

#include <yaml-cpp/yaml.h>

#include <array>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/imu_data.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

struct Figure {
  double ImuNoise::*value;
  const char* name;
  /// Between which densities sensors lie, from the best of aircraft to those of toys.
  double least;
  double most;
  /// The keys of EuRoC and Kalibr, VINS-Fusion, ORB-SLAM3.
  std::array<const char*, 3> keys;
};

constexpr Figure kFigures[] = {{&ImuNoise::gyroscope_density,
                                "the gyroscope's noise",
                                1e-7,
                                0.1,
                                {"gyroscope_noise_density", "gyr_n", "IMU.NoiseGyro"}},
                               {&ImuNoise::gyroscope_random_walk,
                                "the gyroscope's random walk",
                                1e-9,
                                0.1,
                                {"gyroscope_random_walk", "gyr_w", "IMU.GyroWalk"}},
                               {&ImuNoise::accelerometer_density,
                                "the accelerometer's noise",
                                1e-6,
                                1.0,
                                {"accelerometer_noise_density", "acc_n", "IMU.NoiseAcc"}},
                               {&ImuNoise::accelerometer_random_walk,
                                "the accelerometer's random walk",
                                1e-8,
                                1.0,
                                {"accelerometer_random_walk", "acc_w", "IMU.AccWalk"}}};

std::string KeyOf(const Figure& figure, std::size_t form) { return figure.keys.at(form); }

bool HasKey(const YAML::Node& node, const std::string& key) {
  return node.IsMap() && node[key].IsDefined();
}

/// The index of the form that has one of its keys.
std::optional<std::size_t> FormOf(const YAML::Node& node) {
  for (std::size_t form = 0; form < kFigures[0].keys.size(); ++form) {
    for (const Figure& figure : kFigures) {
      if (HasKey(node, KeyOf(figure, form))) {
        return form;
      }
    }
  }
  return std::nullopt;
}

ImuNoise NoiseOf(const YAML::Node& node, std::size_t form, const fs::path& path,
                 ImuCalibration& calibration) {
  ImuNoise noise;
  for (const Figure& figure : kFigures) {
    const std::string key = KeyOf(figure, form);
    const double value = YamlNumbers(node, key, 1, path)[0];
    if (!(value > 0.0)) {
      throw Error(path.string() + ": " + key + " is " + std::to_string(value) +
                  ", expected a density above 0");
    }
    if (value < figure.least || value > figure.most) {
      calibration.warnings.push_back(path.string() + ": " + key + ", " + figure.name +
                                     ", is unlike any sensor's: expected a density in continuous "
                                     "time (per root hertz)");
    }
    noise.*figure.value = value;
  }
  return noise;
}

ImuCalibration Parse(const YAML::Node& root, const fs::path& path) {
  const bool is_chain = HasKey(root, "imu0") && root["imu0"].IsMap();
  const YAML::Node node = is_chain ? root["imu0"] : root;
  const std::optional<std::size_t> form = FormOf(node);
  ImuCalibration calibration;
  const bool is_euroc = HasKey(node, "T_BS");
  // Kalibr's is of the camera's body where several units are chained, and the identity for one.
  const bool is_kalibr = HasKey(node, "T_i_b");
  if (!form && !is_euroc && !is_kalibr) {
    throw Error(path.string() +
                ": no calibration of an inertial unit, expected gyroscope_noise_density, "
                "gyroscope_random_walk, accelerometer_noise_density and accelerometer_random_walk "
                "(EuRoC's sensor.yaml, Kalibr's imu.yaml)");
  }
  if (form) {
    calibration.noise = NoiseOf(node, *form, path, calibration);
  }
  if (is_euroc || is_kalibr) {
    const std::string key = is_euroc ? "T_BS" : "T_i_b";
    const Rigid3 transform = RigidFromRows(YamlNumbers(node, key, 0, path), key, path);
    calibration.body_from_imu = is_euroc ? transform : transform.Inverse();
  }
  return calibration;
}

}  // namespace

ImuCalibration ReadImuCalibration(const fs::path& path) {
  const YAML::Node root = ReadYaml(path);
  try {
    return Parse(root, path);
  } catch (const YAML::Exception& error) {
    throw Error(path.string() + ": " + error.msg);
  }
}

}  // namespace gluevo::vo
