#include "calibration_parts.h"

#include <algorithm>
#include <cmath>

#include "gluevo/nn/error.h"
#include "text_file.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

struct LensName {
  std::string_view name;
  Distortion distortion;
};

// In lower case.
constexpr LensName kLensNames[] = {{"radial-tangential", Distortion::kRadialTangential},
                                   {"radial_tangential", Distortion::kRadialTangential},
                                   {"radtan", Distortion::kRadialTangential},
                                   {"radtan5", Distortion::kRadialTangential},
                                   {"plumb_bob", Distortion::kRadialTangential},
                                   {"brown_conrady", Distortion::kRadialTangential},
                                   {"radtan8", Distortion::kRadialTangential},
                                   {"rational", Distortion::kRadialTangential},
                                   {"rational_polynomial", Distortion::kRadialTangential},
                                   {"equidistant", Distortion::kEquidistant},
                                   {"equi", Distortion::kEquidistant},
                                   {"fisheye", Distortion::kEquidistant},
                                   {"kannala_brandt", Distortion::kEquidistant},
                                   {"kannalabrandt8", Distortion::kEquidistant},
                                   {"kb4", Distortion::kEquidistant},
                                   {"fov", Distortion::kFieldOfView},
                                   {"none", Distortion::kNone}};

bool AllZero(const std::vector<double>& numbers, std::size_t first) {
  return std::all_of(numbers.begin() + static_cast<std::ptrdiff_t>(std::min(first, numbers.size())),
                     numbers.end(), [](double value) { return value == 0.0; });
}

// OpenCV's vectors: k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]].
void SetPolynomialLens(const std::vector<double>& d, const std::string& where, Camera& camera) {
  constexpr std::size_t kOfRadialTangential = 5;
  constexpr std::size_t kOfRational = 8;
  // ROS writes an empty list for a camera without distortion.
  if (d.empty()) {
    camera.distortion = Distortion::kNone;
    return;
  }
  const bool known_length = d.size() == 4 || d.size() == kOfRadialTangential ||
                            d.size() == kOfRational || d.size() == 12 || d.size() == 14;
  if (!known_length) {
    throw Error(where + " has " + std::to_string(d.size()) +
                " coefficients, expected 4, 5 or 8: k1 k2 p1 p2 [k3 [k4 k5 k6]]");
  }
  if (!AllZero(d, kOfRational)) {
    throw Error(
        where + " has " + std::to_string(d.size()) +
        " coefficients, those of a thin prism or a tilted sensor not being zero, expected 4, "
        "5 or 8: k1 k2 p1 p2 [k3 [k4 k5 k6]]");
  }
  camera.distortion =
      AllZero(d, kOfRadialTangential) ? Distortion::kRadialTangential : Distortion::kRational;
  std::copy_n(d.begin(), std::min(d.size(), kOfRational), camera.coefficients.begin());
}

// Kalibr's intrinsics have the parameters of the projection first.
struct ProjectionName {
  std::string_view name;
  Distortion distortion;
  std::size_t parameters;  // before fx fy cx cy
};

constexpr ProjectionName kProjections[] = {{"pinhole", Distortion::kNone, 0},
                                           {"omni", Distortion::kMei, 1},
                                           {"mei", Distortion::kMei, 1},
                                           {"ds", Distortion::kDoubleSphere, 2},
                                           {"eucm", Distortion::kExtendedUnified, 2}};

Rigid3 FromRows(const std::vector<double>& rows, const std::string& key, const fs::path& path,
                Calibration& calibration) {
  std::string rounded;
  const Rigid3 pose = RigidFromRows(rows, key, path, &rounded);
  if (!rounded.empty()) {
    calibration.warnings.push_back(path.string() + ": " + rounded);
  }
  return pose;
}

}  // namespace

void SetLens(const std::string& name, const std::vector<double>& coefficients,
             const std::string& where, Camera& camera) {
  const std::string lower = Lowercase(name);
  const auto* const found = std::find_if(std::begin(kLensNames), std::end(kLensNames),
                                         [&](const LensName& lens) { return lens.name == lower; });
  const bool unnamed = name.empty() && AllZero(coefficients, 0);
  if (found == std::end(kLensNames) && !unnamed) {
    throw Error(where + ": distortion model " + Quoted(name) +
                " is not known, expected radial-tangential, radtan, plumb_bob, "
                "rational_polynomial, equidistant, fisheye, fov or none");
  }
  const Distortion distortion = unnamed ? Distortion::kNone : found->distortion;
  if (distortion == Distortion::kNone) {
    camera.distortion = distortion;
  } else if (distortion == Distortion::kRadialTangential) {
    SetPolynomialLens(coefficients, where, camera);
  } else {
    const std::vector<std::string_view> names = CoefficientNames(distortion);
    if (coefficients.size() < names.size() || !AllZero(coefficients, names.size())) {
      throw Error(where + " has " + std::to_string(coefficients.size()) +
                  " coefficients, expected " + std::to_string(names.size()) + " of the model " +
                  std::string(NameOf(distortion)));
    }
    camera.distortion = distortion;
    std::copy_n(coefficients.begin(), names.size(), camera.coefficients.begin());
  }
}

void SetSize(double width, double height, const fs::path& path, Camera& camera) {
  camera.width = YamlSize(width, "the image width", path);
  camera.height = YamlSize(height, "the image height", path);
}

void SetMatrix(const std::vector<double>& rows, const std::string& where, Camera& camera) {
  const bool is_matrix = rows.size() == 9 && rows[0] > 0.0 && rows[4] > 0.0 && rows[3] == 0.0 &&
                         rows[6] == 0.0 && rows[7] == 0.0 && std::abs(rows[8] - 1.0) < 1e-9;
  if (!is_matrix) {
    throw Error(where + " is no camera matrix, expected [fx 0 cx; 0 fy cy; 0 0 1] in pixels");
  }
  constexpr double kMostSkew = 0.1;
  if (std::abs(rows[1]) > kMostSkew) {
    throw Error(where + " has a skew of " + std::to_string(rows[1]) +
                " pixels, expected 0: no camera model here has one");
  }
  camera.fx = rows[0];
  camera.fy = rows[4];
  camera.cx = rows[2];
  camera.cy = rows[5];
}

Camera CameraFromYaml(const YAML::Node& node, const fs::path& path) {
  // Kalibr's command line, and some that copy it, join projection and distortion: "pinhole-equi".
  std::string model = YamlText(node, "camera_model", path).value_or("pinhole");
  std::string lens;
  if (const std::size_t dash = model.find('-'); dash != std::string::npos) {
    lens = model.substr(dash + 1);
    model.resize(dash);
  }
  model = Lowercase(model);
  const auto* const projection =
      std::find_if(std::begin(kProjections), std::end(kProjections),
                   [&](const ProjectionName& known) { return known.name == model; });
  if (projection == std::end(kProjections)) {
    throw Error(path.string() + ": camera model " + Quoted(model) +
                " is not supported, expected pinhole, omni, ds or eucm");
  }
  Camera camera;
  if (node["resolution"]) {
    const std::vector<double> resolution = YamlNumbers(node, "resolution", 2, path);
    SetSize(resolution[0], resolution[1], path, camera);
  }
  const std::size_t first = projection->parameters;
  const std::vector<double> k = YamlNumbers(node, "intrinsics", first + 4, path);
  camera.fx = k[first];
  camera.fy = k[first + 1];
  camera.cx = k[first + 2];
  camera.cy = k[first + 3];
  const std::optional<std::string> named = YamlText(node, "distortion_model", path);
  if (!named && lens.empty()) {
    throw Error(path.string() + ": no distortion_model");
  }
  lens = named.value_or(lens);
  const char* const key =
      node["distortion_coefficients"] ? "distortion_coefficients" : "distortion_coeffs";
  const std::vector<double> coefficients =
      Lowercase(lens) == "none" ? std::vector<double>() : YamlNumbers(node, key, 0, path);
  SetLens(lens, coefficients, path.string() + ": " + key, camera);
  if (first == 0) {
    return camera;
  }
  const bool omni_with_radtan = projection->distortion == Distortion::kMei &&
                                camera.distortion == Distortion::kRadialTangential &&
                                camera.coefficients[4] == 0.0;
  if (camera.distortion != Distortion::kNone && !omni_with_radtan) {
    throw Error(path.string() + ": camera model " + model + " with distortion model " + lens +
                " is not supported");
  }
  camera.distortion = projection->distortion;
  std::copy_backward(camera.coefficients.begin(), camera.coefficients.end() - first,
                     camera.coefficients.end());
  std::copy_n(k.begin(), first, camera.coefficients.begin());
  return camera;
}

Rigid3 TransformFromYaml(const YAML::Node& node, const std::string& key, const fs::path& path,
                         Calibration& calibration) {
  return FromRows(YamlNumbers(node, key, 0, path), key, path, calibration);
}

Rigid3 TransformFromParts(const std::vector<double>& rotation,
                          const std::vector<double>& translation, const std::string& key,
                          const fs::path& path, Calibration& calibration) {
  const std::vector<double>& t = translation;
  if (t.size() != 3) {
    throw Error(path.string() + ": the translation beside " + key + " has " +
                std::to_string(t.size()) + " numbers, expected 3");
  }
  if (rotation.size() == 3) {
    const Eigen::Vector3d vector(rotation[0], rotation[1], rotation[2]);
    const double angle = vector.norm();
    Rigid3 pose;
    pose.translation = Eigen::Vector3d(t[0], t[1], t[2]);
    if (angle > 0.0) {
      pose.rotation = Eigen::AngleAxisd(angle, vector / angle);
    }
    return pose;
  }
  if (rotation.size() != 9) {
    throw Error(path.string() + ": " + key + " has " + std::to_string(rotation.size()) +
                " numbers, expected a 3 x 3 matrix or a rotation vector");
  }
  const std::vector<double>& r = rotation;
  return FromRows({r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2]}, key,
                  path, calibration);
}

Rigid3 RightFromLeft(const std::array<Rectification, 2>& rectifications,
                     const std::array<fs::path, 2>& paths, Calibration& calibration) {
  std::array<Rigid3, 2> rectified_from_cam;
  std::array<Eigen::Vector3d, 2> offsets;  // Of a point's coordinates, from the common frame.
  for (std::size_t side = 0; side < 2; ++side) {
    rectified_from_cam[side] =
        TransformFromParts(rectifications[side].rotation, {0.0, 0.0, 0.0},
                           "the rectifying rotation", paths[side], calibration);
    const std::vector<double>& p = rectifications[side].projection;
    if (p.size() != 12 || !(p[0] > 0.0) || !(p[5] > 0.0)) {
      throw Error(
          paths[side].string() +
          ": the projection is not [fx 0 cx tx; 0 fy cy ty; 0 0 1 0] of a rectified camera");
    }
    offsets[side] = Eigen::Vector3d(p[3] / p[0], p[7] / p[5], 0.0);
  }
  const Eigen::Vector3d offset = offsets[1] - offsets[0];
  if (offset.norm() == 0.0) {
    throw Error(paths[1].string() +
                ": the projections of left and right have no baseline between them: these cameras "
                "were calibrated one by one, expected a stereo calibration");
  }
  const Rigid3 right_from_left{Eigen::Quaterniond::Identity(), offset};
  return rectified_from_cam[1].Inverse() * right_from_left * rectified_from_cam[0];
}

}  // namespace gluevo::vo
