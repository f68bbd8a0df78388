#include "gluevo/vo/io/imu_data.h"

#include <cmath>
#include <system_error>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "imu_faults.h"
#include "imu_source.h"
#include "imu_table.h"
#include "imu_units.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

bool IsFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

ImuData Refused(const fs::path& path, const std::string& why) {
  ImuData data;
  data.path = path;
  data.refused = why;
  return data;
}

/// Noise and mounting of a calibration file; what is not known is EuRoC's unit's, and said.
void Calibrate(const std::vector<fs::path>& files, bool is_named, ImuData& data) {
  const auto assumed = [&](const std::string& why) {
    data.warnings.push_back(why + ": the noise of EuRoC's unit (ADIS16448) is assumed");
  };
  for (const fs::path& file : files) {
    if (!is_named && !IsFile(file)) {
      continue;
    }
    try {
      const ImuCalibration calibration = ReadImuCalibration(file);
      data.warnings.insert(data.warnings.end(), calibration.warnings.begin(),
                           calibration.warnings.end());
      data.imu_in_body = calibration.body_from_imu.translation;
      for (ImuSample& sample : data.samples) {
        sample.angular_velocity = calibration.body_from_imu.rotation * sample.angular_velocity;
        sample.specific_force = calibration.body_from_imu.rotation * sample.specific_force;
      }
      data.noise = calibration.noise.value_or(ImuNoise());
      if (!calibration.noise) {
        assumed(file.string() + " has no noise of the sensor");
      }
      return;
    } catch (const Error& error) {
      if (is_named) {
        throw;
      }
      assumed(error.what());
      return;
    }
  }
  assumed("no calibration of the inertial unit");
}

void TakeOffShift(double shift_s, ImuData& data) {
  constexpr double kLongest = 100.0;
  data.time_shift_s = shift_s;
  if (std::abs(shift_s) > kLongest) {
    data.refused = "the calibration's time shift of the inertial unit is " +
                   std::to_string(shift_s) + " s, expected seconds, mostly below 0.1";
    return;
  }
  const int64_t shift_ns = std::llround(1e9 * shift_s);
  for (ImuSample& sample : data.samples) {
    sample.timestamp_ns -= shift_ns;
  }
  if (shift_ns != 0) {
    data.notes.push_back("the calibration's time shift of " + std::to_string(1e3 * shift_s) +
                         " ms is taken off the samples' times");
  }
}

}  // namespace

ImuFiles EurocImuFiles(const fs::path& mav0) {
  const fs::path folder = mav0 / "imu0";
  // TUM-VI has its calibrations beside mav0, in Kalibr's form.
  const fs::path above = FolderPath(mav0).parent_path();
  return {folder / "data.csv", {folder / "sensor.yaml", above / "dso" / "imu_config.yaml"}};
}

ImuData ReadImuTable(const fs::path& path) {
  ImuTable table = ParseImuTable(ReadText(path), path);
  ImuData data;
  data.path = path;
  data.samples = std::move(table.samples);
  data.notes = std::move(table.notes);
  data.warnings = std::move(table.warnings);
  FitUnitOfForces(data);
  if (data.refused.empty()) {
    FitUnitOfRates(data);
    CleanImu(data);
  }
  return data;
}

void AddImu(const DatasetOptions& options, const ImuFiles& files, Dataset& dataset) {
  const fs::path table = options.imu.value_or(files.table);
  if (!options.imu && !IsFile(table)) {
    if (options.imu_calibration) {
      throw Error(options.imu_calibration->string() +
                  ": the calibration of an inertial unit, but " + dataset.root.string() +
                  " has no readings of one");
    }
    std::error_code ignored;
    if (fs::is_directory(table.parent_path(), ignored)) {
      dataset.imu = Refused(table, table.string() +
                                       ": no such file, expected the readings of the inertial "
                                       "unit whose folder is there");
    }
    return;
  }
  try {
    ImuData data = ReadImuTable(table);
    if (dataset.rig.body_frame != "imu (body)" && data.refused.empty()) {
      data.refused = dataset.calibration.string() +
                     ": does not say where the inertial unit is, expected T_cam_imu of the left "
                     "camera or the like";
    }
    Calibrate(options.imu_calibration ? std::vector<fs::path>{*options.imu_calibration}
                                      : files.calibrations,
              options.imu_calibration.has_value(), data);
    TakeOffShift(dataset.imu_time_shift_s, data);
    dataset.imu = std::move(data);
  } catch (const Error& error) {
    if (options.imu || options.imu_calibration) {
      throw;
    }
    dataset.imu = Refused(table, error.what());
  }
}

void AddOxts(const std::string& left_number, int64_t origin_ns, Dataset& dataset) {
  const fs::path oxts = dataset.root / "oxts";
  std::error_code ignored;
  if (!fs::is_directory(oxts / "data", ignored)) {
    return;
  }
  try {
    ImuData data = ReadOxts(oxts, origin_ns);
    const Rigid3 left_from_imu =
        LeftFromOxts(KittiCalibration(dataset.calibration), left_number,
                     dataset.rig.cameras[0].distortion == Distortion::kNone);
    data.imu_in_body = left_from_imu.translation;
    for (ImuSample& sample : data.samples) {
      sample.angular_velocity = left_from_imu.rotation * sample.angular_velocity;
      sample.specific_force = left_from_imu.rotation * sample.specific_force;
    }
    dataset.imu = std::move(data);
  } catch (const Error& error) {
    dataset.imu = Refused(oxts, error.what());
  }
}

std::optional<ImuData> FindImu(const fs::path& root) {
  for (const fs::path& mav0 : {root / "mav0", root}) {
    const ImuFiles files = EurocImuFiles(mav0);
    if (!IsFile(files.table)) {
      continue;
    }
    try {
      ImuData data = ReadImuTable(files.table);
      Calibrate(files.calibrations, /*is_named=*/false, data);
      return data;
    } catch (const Error& error) {
      return Refused(files.table, error.what());
    }
  }
  const fs::path oxts = root / "oxts";
  std::error_code ignored;
  if (!fs::is_directory(oxts / "data", ignored)) {
    return std::nullopt;
  }
  try {
    return ReadOxts(oxts, FirstDate(oxts / "timestamps.txt"));
  } catch (const Error& error) {
    return Refused(oxts, error.what());
  }
}

}  // namespace gluevo::vo
