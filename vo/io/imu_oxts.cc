// The inertial unit of KITTI's raw drives (Geiger et al. 2013).

#include <algorithm>
#include <array>

#include "gluevo/nn/error.h"
#include "imu_faults.h"
#include "imu_source.h"
#include "imu_units.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kForces = 11;
constexpr std::size_t kRates = 17;

/// Files whose names are numbers, and these.
std::vector<std::pair<int64_t, fs::path>> NumberedFiles(const fs::path& folder) {
  std::vector<std::pair<int64_t, fs::path>> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::optional<int64_t> number = ParseInteger(entry.path().stem().string());
    if (entry.path().extension() == ".txt" && number && *number >= 0) {
      files.emplace_back(*number, entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

ImuSample ReadReading(const fs::path& file, int64_t time_ns) {
  const std::string text = ReadText(file);
  const auto fields = SplitFields(text, ' ');
  std::array<double, 6> values = {};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t field = i < 3 ? kForces + i : kRates + i - 3;
    const std::optional<double> value =
        field < fields.size() ? ParseNumber(fields[field]) : std::nullopt;
    if (!value) {
      throw Error(file.string() + ": no finite number in field " + std::to_string(field) +
                  ", expected KITTI's oxts: 30 numbers, accelerations from 11 on, rates from 17");
    }
    values[i] = *value;
  }
  return {time_ns, {values[3], values[4], values[5]}, {values[0], values[1], values[2]}};
}

/// R and T of KITTI's calibration files, with what follows these letters.
Rigid3 TransformOf(const KittiCalibration& calibration, const std::string& suffix) {
  const std::vector<double>& t = calibration.Get("T" + suffix, 3);
  return KittiTransform(calibration, "R" + suffix, {t[0], t[1], t[2]});
}

/// left_from_reference: the reference is camera 0 before it is rectified.
Rigid3 LeftFromReference(const KittiCalibration& cameras, const std::string& number,
                         bool is_rectified) {
  if (!is_rectified) {
    return TransformOf(cameras, '_' + number);
  }
  // P = K [I | t] of the rectified camera; all are rectified by the rotation of camera 0.
  const std::vector<double>& p = cameras.Get("P_rect_" + number, 12);
  const double z = p[11];
  return KittiTransform(cameras, "R_rect_00",
                        {(p[3] - p[2] * z) / p[0], (p[7] - p[6] * z) / p[5], z});
}

}  // namespace

int64_t FirstDate(const fs::path& timestamps) {
  const std::vector<std::optional<int64_t>> dates = ParseDates(ReadText(timestamps), timestamps);
  if (dates.empty() || !dates.front()) {
    throw Error(timestamps.string() + ": no times in it");
  }
  return *dates.front();
}

ImuData ReadOxts(const fs::path& oxts, int64_t origin_ns) {
  const fs::path times_file = oxts / "timestamps.txt";
  const std::vector<std::optional<int64_t>> dates = ParseDates(ReadText(times_file), times_file);
  ImuData data;
  data.path = oxts;
  const auto files = NumberedFiles(oxts / "data");
  data.samples.reserve(files.size());
  std::size_t without = 0;
  for (const auto& [number, file] : files) {
    const auto row = static_cast<std::size_t>(number);
    if (row >= dates.size() || !dates[row]) {
      ++without;
      continue;
    }
    data.samples.push_back(ReadReading(file, *dates[row] - origin_ns));
  }
  if (data.samples.empty()) {
    throw Error(oxts.string() + ": no readings with a time in timestamps.txt");
  }
  if (without > 0) {
    data.warnings.push_back(std::to_string(without) + " of " + std::to_string(files.size()) +
                            " readings have no time in " + times_file.string() +
                            " and are left out");
  }
  data.notes.emplace_back(
      "no calibration of the inertial unit: the noise of EuRoC's unit (ADIS16448) is assumed");
  FitUnitOfForces(data);
  if (data.refused.empty()) {
    FitUnitOfRates(data);
    CleanImu(data);
  }
  if (!data.refused.empty() && data.rate_hz > 0.0 && data.rate_hz < kLeastImuRateHz) {
    data.refused += " (a drive's \"extract\" form has 100, its \"sync\" form one an image)";
  }
  return data;
}

Rigid3 LeftFromOxts(const KittiCalibration& cameras, const std::string& number, bool is_rectified) {
  const fs::path folder = cameras.path().parent_path();
  const Rigid3 velo_from_imu = TransformOf(KittiCalibration(folder / "calib_imu_to_velo.txt"), "");
  const Rigid3 reference_from_velo =
      TransformOf(KittiCalibration(folder / "calib_velo_to_cam.txt"), "");
  return LeftFromReference(cameras, number, is_rectified) * reference_from_velo * velo_from_imu;
}

}  // namespace gluevo::vo
