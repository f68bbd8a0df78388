#include "kitti_files.h"

#include <Eigen/LU>
#include <algorithm>
#include <optional>
#include <string_view>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/image_file.h"
#include "text_file.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

std::vector<KeyedImage> ListNumbered(const fs::path& folder) {
  CheckFolder(folder, "a camera of a KITTI data set");
  std::vector<KeyedImage> images;
  const std::vector<fs::path> files = ListImages(folder);
  if (files.empty()) {
    throw Error(NoImagesMessage(folder));
  }
  for (const fs::path& image : files) {
    const std::optional<int64_t> number = ParseInteger(image.stem().string());
    if (number && *number >= 0) {
      images.push_back({*number, image});
    }
  }
  if (images.empty()) {
    throw Error(folder.string() + ": no images whose names are numbers");
  }
  std::stable_sort(images.begin(), images.end(),
                   [](const KeyedImage& a, const KeyedImage& b) { return a.key < b.key; });
  return images;
}

}  // namespace

KittiCalibration::KittiCalibration(const fs::path& path) : path_(path) {
  for (const TextLine& line : ReadLines(path_, /*skip_comments=*/true)) {
    const std::size_t colon = line.text.find(':');
    if (colon == std::string::npos) {
      throw Error(At(path_, line) + ": expected \"KEY: numbers\"");
    }
    std::vector<double> numbers;
    bool all_numbers = true;
    for (const std::string_view field :
         SplitFields(std::string_view(line.text).substr(colon + 1), ' ')) {
      const std::optional<double> number = ParseNumber(field);
      all_numbers = all_numbers && number;
      numbers.push_back(number.value_or(0.0));
    }
    if (all_numbers) {
      values_[line.text.substr(0, colon)] = std::move(numbers);
    }
  }
}

const std::vector<double>& KittiCalibration::Get(const std::string& key, std::size_t count) const {
  const auto found = values_.find(key);
  if (found == values_.end()) {
    throw Error(path_.string() + ": no " + key + ", expected " + std::to_string(count) +
                " numbers");
  }
  if (found->second.size() != count) {
    throw Error(path_.string() + ": " + key + " has " + std::to_string(found->second.size()) +
                " numbers, expected " + std::to_string(count));
  }
  return found->second;
}

StereoRig RectifiedRig(const KittiCalibration& calibration, const std::array<std::string, 2>& keys,
                       const std::array<int, 2>& size) {
  StereoRig rig;
  rig.body_frame = "left camera";
  std::array<Eigen::Vector3d, 2> offsets;  // Of a point's coordinates from the common frame.
  for (std::size_t side = 0; side < 2; ++side) {
    const std::vector<double>& p = calibration.Get(keys[side], 12);
    Camera& camera = rig.cameras[side];
    camera = {size[0], size[1], /*fx=*/p[0], /*fy=*/p[5], /*cx=*/p[2], /*cy=*/p[6]};
    camera.Validate(calibration.path().string() + ": " + keys[side]);
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> projection(p.data());
    Eigen::Matrix3d intrinsics;
    intrinsics << camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0;
    if (!projection.leftCols<3>().isApprox(intrinsics)) {
      throw Error(calibration.path().string() + ": " + keys[side] +
                  " is not the projection [fx 0 cx; 0 fy cy; 0 0 1] [I | t] of a rectified camera");
    }
    offsets[side] = intrinsics.inverse() * projection.col(3);
  }
  rig.body_from_cam[1].translation = offsets[0] - offsets[1];
  if (!(rig.body_from_cam[1].translation.x() > 0.0)) {
    throw Error(calibration.path().string() + ": " + keys[1] + " has a baseline of " +
                std::to_string(rig.body_from_cam[1].translation.x()) +
                " m, expected the right camera to the right of the left one");
  }
  return rig;
}

std::vector<ImagePair> ListNumberedPairs(const std::array<fs::path, 2>& folders, Dataset& dataset) {
  const ImagePairs pairs =
      PairImages({ListNumbered(folders[0]), ListNumbered(folders[1])}, 0, "number");
  if (pairs.pairs.empty()) {
    throw Error(folders[0].string() + ": no image has the same number as one in " +
                folders[1].string());
  }
  ReportPairs(pairs, /*stamped=*/false, dataset);
  return pairs.pairs;
}

Rigid3 KittiTransform(const KittiCalibration& calibration, const std::string& key,
                      const Eigen::Vector3d& t) {
  const std::vector<double>& r = calibration.Get(key, 9);
  return RigidFromRows({r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2]},
                       key, calibration.path());
}

std::vector<std::optional<int64_t>> ParseDates(std::string_view text, const fs::path& path) {
  std::vector<std::optional<int64_t>> times;
  for (const TextLine& line : SplitLines(text, path, /*skip_comments=*/false)) {
    if (line.text.empty() && !times.empty()) {
      times.emplace_back();
      continue;
    }
    const std::optional<int64_t> time = ParseDateTime(line.text);
    if (!time) {
      throw Error(At(path, line) + ": " + Quoted(line.text) +
                  " is not a time, expected YYYY-MM-DD HH:MM:SS.nnnnnnnnn");
    }
    times.emplace_back(*time);
  }
  return times;
}

std::vector<std::optional<int64_t>> ParseTimestamps(std::string_view text, const fs::path& path) {
  std::vector<std::optional<int64_t>> times = ParseDates(text, path);
  const int64_t first = times.empty() ? 0 : times.front().value_or(0);
  for (std::optional<int64_t>& time : times) {
    time = time ? std::optional(*time - first) : time;
  }
  return times;
}

fs::path FindAbove(const fs::path& folder, const std::vector<fs::path>& files) {
  constexpr int kFoldersAbove = 3;
  fs::path place = FolderPath(folder);
  for (int level = 0; level <= kFoldersAbove; ++level, place = place.parent_path()) {
    for (const fs::path& file : files) {
      if (fs::exists(place / file)) {
        return place / file;
      }
    }
  }
  std::string names;
  for (const fs::path& file : files) {
    names += (names.empty() ? "" : " or ") + file.string();
  }
  throw Error(folder.string() + ": no " + names + " in it or in the three folders above it");
}

}  // namespace gluevo::vo
