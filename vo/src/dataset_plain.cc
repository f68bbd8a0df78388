// Two folders of images that pair by name, with a calibration file.

#include <algorithm>
#include <set>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "text_file.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

std::optional<std::array<fs::path, 2>> FindFolders(const fs::path& root) {
  constexpr const char* kNames[][2] = {
      {"left", "right"}, {"cam0", "cam1"}, {"image_0", "image_1"}, {"image_00", "image_01"}};
  for (const auto& [left, right] : kNames) {
    if (fs::is_directory(root / left) && fs::is_directory(root / right)) {
      std::array<fs::path, 2> folders = {root / left, root / right};
      for (fs::path& folder : folders) {
        folder = fs::is_directory(folder / "data") ? folder / "data" : folder;
      }
      return folders;
    }
  }
  return std::nullopt;
}

// OpenCV's stereoCalibrate sample: image size, K1 D1 K2 D2 (or M1, M2), R and T from the first to
// the second camera. `distortion_model` may say equidistant.
StereoRig RigFromOpenCv(const YAML::Node& root, const fs::path& path) {
  StereoRig rig;
  rig.body_frame = "left camera";
  const int width = static_cast<int>(YamlNumbers(root, "image_width", 1, path)[0]);
  const int height = static_cast<int>(YamlNumbers(root, "image_height", 1, path)[0]);
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string number = std::to_string(side + 1);
    const std::vector<double> k =
        YamlNumbers(root, (root["M" + number] ? "M" : "K") + number, 9, path);
    const std::vector<double> d = YamlNumbers(root, "D" + number, 0, path);
    Camera& camera = rig.cameras[side];
    camera.width = width;
    camera.height = height;
    camera.fx = k[0];
    camera.fy = k[4];
    camera.cx = k[2];
    camera.cy = k[5];
    camera.distortion = root["distortion_model"]
                            ? DistortionFromName(root["distortion_model"].as<std::string>(), path)
                            : Distortion::kRadialTangential;
    const std::size_t most = camera.coefficients.size();
    if (d.size() > most && std::any_of(d.begin() + static_cast<std::ptrdiff_t>(most), d.end(),
                                       [](double v) { return v != 0.0; })) {
      throw Error(path.string() + ": D" + number +
                  " has more than 5 coefficients, expected k1 k2 "
                  "p1 p2 k3");
    }
    std::copy_n(d.begin(), std::min(d.size(), most), camera.coefficients.begin());
    camera.Validate(path.string());
  }
  const std::vector<double> r = YamlNumbers(root, "R", 9, path);
  const std::vector<double> t = YamlNumbers(root, "T", 3, path);
  rig.body_from_cam[1] =
      RigidFromRows({r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2]}, "R",
                    path)
          .Inverse();
  return rig;
}

// Times from names that are all nanoseconds (16 digits and more) or all decimal seconds; else ten
// images a second.
std::vector<int64_t> TimesFromNames(const std::vector<fs::path>& images) {
  std::vector<int64_t> times;
  for (const fs::path& image : images) {
    const std::string stem = image.stem().string();
    std::optional<int64_t> time;
    if (stem.find('.') != std::string::npos) {
      time = ParseSeconds(stem);
    } else if (stem.size() >= 16) {
      time = ParseInteger(stem);
    }
    if (!time || (!times.empty() && *time <= times.back())) {
      break;
    }
    times.push_back(*time);
  }
  if (times.size() != images.size()) {
    times.clear();
    for (std::size_t i = 0; i < images.size(); ++i) {
      times.push_back(static_cast<int64_t>(i) * 100'000'000);
    }
  }
  return times;
}

}  // namespace

bool IsPlain(const fs::path& root) { return FindFolders(root).has_value(); }

Dataset OpenPlain(const fs::path& root, const DatasetOptions& options) {
  const auto folders = FindFolders(root);
  if (!folders) {
    throw Error(root.string() +
                ": no two folders of images in it, expected left and right, cam0 and cam1, "
                "image_0 and image_1, or image_00 and image_01");
  }
  if (!options.calibration) {
    throw Error(root.string() + ": a plain data set needs a calibration file (--calibration)");
  }
  Dataset dataset;
  dataset.root = root;
  dataset.format = DatasetFormat::kPlain;
  const YAML::Node calibration = ReadYaml(*options.calibration);
  dataset.rig = calibration["cam0"] ? RigFromCamchain(*options.calibration)
                                    : RigFromOpenCv(calibration, *options.calibration);
  std::set<fs::path> right_names;
  for (const fs::path& image : ListImages((*folders)[1])) {
    right_names.insert(image.filename());
  }
  std::vector<fs::path> left;
  for (const fs::path& image : ListImages((*folders)[0])) {
    if (right_names.contains(image.filename())) {
      left.push_back(image);
    }
  }
  if (left.empty()) {
    throw Error((*folders)[0].string() + ": no image has a mate of the same name in " +
                (*folders)[1].string());
  }
  const std::vector<int64_t> times = TimesFromNames(left);
  for (std::size_t i = 0; i < left.size(); ++i) {
    dataset.entries.push_back({times[i], {left[i], (*folders)[1] / left[i].filename()}});
  }
  if (options.groundtruth) {
    dataset.groundtruth = ReadTrajectory(*options.groundtruth);
  }
  return dataset;
}

}  // namespace gluevo::vo
