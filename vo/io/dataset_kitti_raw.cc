// KITTI raw drives (Geiger et al. 2013), unrectified or rectified.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <string_view>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "kitti_files.h"
#include "text_file.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

// "2011-09-26 13:02:25.964389445", in nanoseconds since 1970.
std::optional<int64_t> ParseDateTime(std::string_view text) {
  const auto fields = SplitFields(text, ' ');
  if (fields.size() != 2) {
    return std::nullopt;
  }
  const auto date = SplitFields(fields[0], '-');
  const auto time = SplitFields(fields[1], ':');
  if (date.size() != 3 || time.size() != 3) {
    return std::nullopt;
  }
  const auto field = [](std::string_view digits, int64_t first,
                        int64_t last) -> std::optional<int64_t> {
    const std::optional<int64_t> value = ParseInteger(digits);
    return value && *value >= first && *value <= last ? value : std::nullopt;
  };
  const auto year = field(date[0], 1900, 2200);
  const auto month = field(date[1], 1, 12);
  const auto day = field(date[2], 1, 31);
  const auto hour = field(time[0], 0, 23);
  const auto minute = field(time[1], 0, 59);
  const auto second_ns = ParseSeconds(time[2]);
  constexpr int64_t kLeapMinuteNs = 61'000'000'000;
  if (!year || !month || !day || !hour || !minute || !second_ns || *second_ns < 0 ||
      *second_ns >= kLeapMinuteNs) {
    return std::nullopt;
  }
  const std::chrono::year_month_day calendar_day(std::chrono::year(static_cast<int>(*year)),
                                                 std::chrono::month(static_cast<unsigned>(*month)),
                                                 std::chrono::day(static_cast<unsigned>(*day)));
  if (!calendar_day.ok()) {
    return std::nullopt;
  }
  const std::chrono::seconds seconds = std::chrono::sys_days(calendar_day).time_since_epoch() +
                                       std::chrono::hours(*hour) + std::chrono::minutes(*minute);
  return std::chrono::nanoseconds(seconds).count() + *second_ns;
}

// The time of each row in nanoseconds after the first; nothing for a blank row.
std::vector<std::optional<int64_t>> ReadRows(const fs::path& path) {
  std::vector<std::optional<int64_t>> times;
  int64_t first = 0;
  for (const TextLine& line : ReadLines(path, /*skip_comments=*/false)) {
    if (line.text.empty() && !times.empty()) {
      times.emplace_back();
      continue;
    }
    const std::optional<int64_t> time = ParseDateTime(line.text);
    if (!time) {
      throw Error(At(path, line) + ": " + Quoted(line.text) +
                  " is not a time, expected YYYY-MM-DD HH:MM:SS.nnnnnnnnn");
    }
    if (times.empty()) {
      first = *time;
    }
    times.emplace_back(*time - first);
  }
  return times;
}

fs::path FindCalibration(const fs::path& root) {
  constexpr int kFoldersAbove = 3;
  fs::path folder = FolderPath(root);
  for (int level = 0; level <= kFoldersAbove; ++level, folder = folder.parent_path()) {
    if (fs::exists(folder / "calib_cam_to_cam.txt")) {
      return folder / "calib_cam_to_cam.txt";
    }
  }
  throw Error(root.string() + ": no calib_cam_to_cam.txt in it or in the three folders above it");
}

std::string Suffix(std::size_t side) { return side == 0 ? "_00" : "_01"; }

// The unrectified cameras 0 and 1. The body is the left camera.
StereoRig UnrectifiedRig(const KittiCalibration& calibration, const std::array<int, 2>& size) {
  StereoRig rig;
  rig.body_frame = "left camera";
  std::array<Rigid3, 2> cam_from_reference;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::vector<double>& k = calibration.Get("K" + Suffix(side), 9);
    const std::vector<double>& d = calibration.Get("D" + Suffix(side), 5);
    const std::vector<double>& r = calibration.Get("R" + Suffix(side), 9);
    const std::vector<double>& t = calibration.Get("T" + Suffix(side), 3);
    Camera& camera = rig.cameras[side];
    camera = {size[0], size[1], /*fx=*/k[0], /*fy=*/k[4], /*cx=*/k[2], /*cy=*/k[5]};
    camera.distortion = Distortion::kRadialTangential;
    std::copy(d.begin(), d.end(), camera.coefficients.begin());
    camera.Validate(calibration.path().string() + ": K" + Suffix(side));
    cam_from_reference[side] =
        RigidFromRows({r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2]},
                      "R" + Suffix(side), calibration.path());
  }
  rig.body_from_cam[1] = cam_from_reference[0] * cam_from_reference[1].Inverse();
  return rig;
}

bool IsSize(const KittiCalibration& calibration, const std::string& key,
            const std::array<int, 2>& size) {
  if (!calibration.Has(key)) {
    return false;
  }
  const std::vector<double>& s = calibration.Get(key, 2);
  return s[0] == size[0] && s[1] == size[1];
}

StereoRig ReadRig(const KittiCalibration& calibration, const fs::path& first_image) {
  const std::array<int, 2> size = ImageSize(first_image);
  if (IsSize(calibration, "S_00", size)) {
    return UnrectifiedRig(calibration, size);
  }
  if (IsSize(calibration, "S_rect_00", size)) {
    return RectifiedRig(calibration, {"P_rect_00", "P_rect_01"}, size);
  }
  throw Error(first_image.string() + ": an image of " + std::to_string(size[0]) + " x " +
              std::to_string(size[1]) +
              " pixels, expected S_00 (unrectified) or S_rect_00 (rectified) of " +
              calibration.path().string());
}

}  // namespace

bool IsKittiRaw(const fs::path& root) {
  return fs::is_directory(root / "image_00") || fs::is_directory(root / "image_01");
}

Dataset OpenKittiRaw(const fs::path& root, const DatasetOptions& options) {
  Dataset dataset;
  dataset.root = root;
  dataset.format = DatasetFormat::kKittiRaw;
  const std::vector<NumberedPair> pairs =
      ListNumberedPairs({root / "image_00" / "data", root / "image_01" / "data"});
  // Of the left camera as published, or of the drive.
  const fs::path camera_times = root / "image_00" / "timestamps.txt";
  const fs::path drive_times = root / "timestamps.txt";
  const fs::path times_file =
      !fs::exists(camera_times) && fs::exists(drive_times) ? drive_times : camera_times;
  const std::vector<std::optional<int64_t>> times = ReadRows(times_file);
  for (const NumberedPair& pair : pairs) {
    if (pair.number >= times.size() || !times[pair.number]) {
      throw Error(times_file.string() + ": has no time in row " + std::to_string(pair.number + 1) +
                  " of " + std::to_string(times.size()) + ", that of " + pair.images[0].string());
    }
    dataset.entries.push_back({*times[pair.number], pair.images});
  }
  dataset.calibration = FindCalibration(root);
  dataset.rig = ReadRig(KittiCalibration(dataset.calibration), pairs.front().images[0]);
  if (options.groundtruth) {
    dataset.groundtruth = ReadTrajectory(*options.groundtruth);
  }
  return dataset;
}

}  // namespace gluevo::vo
