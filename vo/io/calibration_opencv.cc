// What programs around OpenCV's stereoCalibrate write: one file, or intrinsics and extrinsics
// apart.

#include <algorithm>
#include <cctype>

#include "calibration_parts.h"
#include "gluevo/nn/error.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

// What people call the parts, in lower case and without '_', '-', '.' and blanks; the side goes
// before or after the name.
const std::vector<std::string_view> kMatrixNames = {
    "k",          "m",         "cameramatrix", "cammatrix", "intrinsicmatrix",
    "intrinsics", "intrinsic", "mtx",          "kk",        "matrix"};
const std::vector<std::string_view> kLensNames = {"d",
                                                  "distcoeffs",
                                                  "distcoeff",
                                                  "distcoefs",
                                                  "distcoef",
                                                  "dist",
                                                  "distortioncoefficients",
                                                  "distortioncoeffs",
                                                  "distortioncoeff",
                                                  "distortion",
                                                  "distortions",
                                                  "kc",
                                                  "coeffs"};
const std::vector<std::string_view> kMirrorNames = {"xi"};
const std::vector<std::string_view> kRotationNames = {
    "r", "rotation", "rotationmatrix", "rot", "om", "rvec", "rmat", "rstereo"};
const std::vector<std::string_view> kTranslationNames = {
    "t", "translation", "translationvector", "trans", "tvec", "tvect", "tstereo"};
const std::vector<std::array<std::string_view, 2>> kSides = {
    {"1", "2"}, {"left", "right"}, {"l", "r"}, {"0", "1"}};

std::string Simplified(const std::string& name) {
  std::string simple;
  for (const unsigned char c : name) {
    if (std::isalnum(c) != 0) {
      simple.push_back(static_cast<char>(std::tolower(c)));
    }
  }
  return simple;
}

// A value under one of several names.
struct Found {
  const CalibrationFile* file = nullptr;
  std::string key;
  explicit operator bool() const { return file != nullptr; }
  std::vector<double> Numbers(std::size_t count = 0) const {
    return YamlNumbers(file->tree, key, count, file->path);
  }
  std::string Place() const { return file->path.string() + ": " + key; }
};

bool IsOfSide(const std::string& simple, std::string_view name, std::string_view side) {
  return simple.size() == name.size() + side.size() &&
         ((simple.starts_with(name) && simple.ends_with(side)) ||
          (simple.starts_with(side) && simple.ends_with(name)));
}

Found Find(const std::vector<CalibrationFile>& files, const std::vector<std::string_view>& names,
           std::string_view side) {
  for (const CalibrationFile& file : files) {
    if (!file.tree.IsMap()) {
      continue;
    }
    for (const auto& entry : file.tree) {
      const std::string simple = Simplified(entry.first.Scalar());
      const bool hit = std::any_of(names.begin(), names.end(), [&](std::string_view name) {
        return IsOfSide(simple, name, side);
      });
      if (hit) {
        return {&file, entry.first.Scalar()};
      }
    }
  }
  return {};
}

// How the file tells left from right: "1" and "2" and so on.
const std::array<std::string_view, 2>* FindSides(const std::vector<CalibrationFile>& files) {
  for (const auto& sides : kSides) {
    if (Find(files, kMatrixNames, sides[0]) && Find(files, kMatrixNames, sides[1])) {
      return &sides;
    }
  }
  return nullptr;
}

bool HasExtrinsics(const std::vector<CalibrationFile>& files) {
  return Find(files, kRotationNames, "") && Find(files, kTranslationNames, "");
}

bool HasOneCamera(const CalibrationFile& file) {
  return Find({file}, kMatrixNames, "") && Find({file}, kLensNames, "");
}

bool Is(const CalibrationFile& file) {
  return FindSides({file}) != nullptr || HasExtrinsics({file}) || HasOneCamera(file);
}

std::string Keys(const std::vector<CalibrationFile>& files) {
  constexpr std::size_t kMostNames = 20;
  std::size_t count = 0;
  std::string keys;
  for (const CalibrationFile& file : files) {
    for (const auto& entry : file.tree) {
      if (++count <= kMostNames) {
        keys += (keys.empty() ? "" : ", ") + entry.first.Scalar();
      }
    }
  }
  return count > kMostNames ? keys + ", ..." : keys;
}

// OpenCV's sample writes intrinsics.yml and extrinsics.yml.
void AddMate(const CalibrationInput& input, std::vector<CalibrationFile>& files,
             Calibration& calibration) {
  constexpr std::array<const char*, 2> kNames[] = {{"intrinsics", "extrinsics"},
                                                   {"intrinsic", "extrinsic"},
                                                   {"Intrinsics", "Extrinsics"},
                                                   {"Intrinsic", "Extrinsic"},
                                                   {"intri", "extri"}};
  const fs::path path = files[0].path;
  const std::string stem = path.filename().string();
  for (const auto& [first, second] : kNames) {
    for (const auto& [from, to] : {std::pair(first, second), std::pair(second, first)}) {
      const std::size_t at = stem.find(from);
      if (at == std::string::npos) {
        continue;
      }
      std::string name = stem;
      name.replace(at, std::string_view(from).size(), to);
      if (auto mate = input.open(path.parent_path() / name)) {
        calibration.files.push_back(mate->path);
        files.push_back(std::move(*mate));
        return;
      }
    }
  }
}

std::optional<std::array<double, 2>> FindSize(const std::vector<CalibrationFile>& files) {
  const Found size = Find(files, {"imagesize", "imgsize", "size", "resolution", "imageshape"}, "");
  if (size) {
    const std::vector<double> numbers = size.Numbers(2);
    // Python's shape is height and width; other names are width and height.
    const bool is_shape = Simplified(size.key) == "imageshape";
    return is_shape ? std::array{numbers[1], numbers[0]} : std::array{numbers[0], numbers[1]};
  }
  const Found width = Find(files, {"imagewidth", "imgwidth", "width", "imagesizewidth", "w"}, "");
  const Found height =
      Find(files, {"imageheight", "imgheight", "height", "imagesizeheight", "h"}, "");
  if (width && height) {
    return std::array{width.Numbers(1)[0], height.Numbers(1)[0]};
  }
  return std::nullopt;
}

std::string LensNameOf(const std::vector<CalibrationFile>& files) {
  for (const CalibrationFile& file : files) {
    for (const char* const key : {"distortion_model", "camera_model", "model"}) {
      if (!file.Has(key)) {
        continue;
      }
      const std::string name = YamlText(file.tree, key, file.path).value_or("");
      if (name != "pinhole" && name != "PINHOLE") {
        return name;
      }
    }
  }
  return "radial-tangential";
}

void ReadCamera(const std::vector<CalibrationFile>& files, std::string_view side, Camera& camera) {
  const Found matrix = Find(files, kMatrixNames, side);
  SetMatrix(matrix.Numbers(), matrix.Place(), camera);
  const std::string name = LensNameOf(files);
  if (name == "none") {
    return;
  }
  const Found lens = Find(files, kLensNames, side);
  if (!lens) {
    throw Error(matrix.file->path.string() + ": no distortion coefficients beside " + matrix.key +
                ", expected D" + std::string(side) + " or distCoeffs" + std::string(side) +
                "; it has " + Keys(files));
  }
  SetLens(name, lens.Numbers(), lens.Place(), camera);
  if (const Found xi = Find(files, kMirrorNames, side)) {
    // The lens of cv::omnidir.
    DistortionCoefficients& k = camera.coefficients;
    k = {xi.Numbers(1)[0], k[0], k[1], k[2], k[3]};
    camera.distortion = Distortion::kMei;
  }
}

// OpenCV's pinhole calibration writes five coefficients and more of itself.
bool IsOldOrFisheye(const std::vector<CalibrationFile>& files, std::string_view side) {
  constexpr std::size_t kCoefficients = 4;
  const bool is_named = std::any_of(files.begin(), files.end(), [](const CalibrationFile& file) {
    return file.Has("distortion_model") || file.Has("camera_model") || file.Has("model");
  });
  return !is_named && !Find(files, kMirrorNames, side) &&
         Find(files, kLensNames, side).Numbers().size() == kCoefficients;
}

void Read(const CalibrationInput& input, Calibration& calibration) {
  std::vector<CalibrationFile> files = input.named;
  const fs::path& path = files[0].path;
  if (files.size() == 1 && (FindSides(files) == nullptr || !HasExtrinsics(files))) {
    AddMate(input, files, calibration);
  }
  const std::array<std::string_view, 2>* const sides = FindSides(files);
  if (sides == nullptr) {
    throw Error(input.named[0].path.string() +
                ": no matrices of two cameras, expected K1 and K2 (M1, cameraMatrix1, "
                "camera_matrix_left, ...), in it or in a second file of intrinsics; it has " +
                Keys(files));
  }
  const Found rotation = Find(files, kRotationNames, "");
  const Found translation = Find(files, kTranslationNames, "");
  if (!rotation || !translation) {
    throw Error(input.named[0].path.string() +
                ": no R and T from the left to the right camera, in it or in a second file of "
                "extrinsics; it has " +
                Keys(files));
  }
  calibration.rig.body_frame = "left camera";
  const std::optional<std::array<double, 2>> size = FindSize(files);
  for (std::size_t side = 0; side < 2; ++side) {
    Camera& camera = calibration.rig.cameras[side];
    ReadCamera(files, (*sides)[side], camera);
    if (size) {
      SetSize((*size)[0], (*size)[1], path, camera);
    }
  }
  if (IsOldOrFisheye(files, (*sides)[0])) {
    calibration.notes.emplace_back(
        "four distortion coefficients are taken as k1 k2 p1 p2; of cv::fisheye they would be k1 to "
        "k4, which distortion_model: fisheye in the file says");
  }
  calibration.rig.body_from_cam[1] =
      TransformFromParts(rotation.Numbers(), translation.Numbers(), rotation.key,
                         rotation.file->path, calibration)
          .Inverse();
}

}  // namespace

const CalibrationForm kOpenCvForm = {
    "OpenCV stereo calibration",
    "OpenCV stereo calibration, YAML or XML (K1 D1 K2 D2 R T, also in two files)", &Is, 2, &Read};

}  // namespace gluevo::vo
