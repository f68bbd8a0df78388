// EuRoC's ASL layout (Burri et al. 2016), and TUM-VI, which uses it with equidistant cameras.

#include <map>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

fs::path Mav0(const fs::path& root) {
  return fs::is_directory(root / "mav0") ? root / "mav0" : root;
}

// File names by time, as data.csv lists them.
std::map<int64_t, fs::path> ListCamera(const fs::path& camera_folder) {
  CheckFolder(camera_folder, "a camera of a EuRoC data set");
  const fs::path csv = camera_folder / "data.csv";
  std::map<int64_t, fs::path> images;
  for (const TextLine& line : ReadLines(csv, /*skip_comments=*/true)) {
    const auto fields = SplitFields(line.text, ',');
    const auto timestamp_ns = ParseInteger(fields[0]);
    if (fields.size() < 2 || !timestamp_ns || fields[1].empty()) {
      throw Error(At(csv, line) + ": expected \"timestamp [ns],filename\"");
    }
    const fs::path image = camera_folder / "data" / std::string(fields[1]);
    CheckImageFile(image);
    if (!images.emplace(*timestamp_ns, image).second) {
      throw Error(At(csv, line) + ": the time " + std::to_string(*timestamp_ns) +
                  " is there twice");
    }
  }
  return images;
}

std::vector<fs::path> OwnCalibration(const fs::path& mav0) {
  const fs::path sensor_file = mav0 / "cam0" / "sensor.yaml";
  // TUM-VI's.
  const fs::path camchain = FolderPath(mav0).parent_path() / "dso" / "camchain.yaml";
  if (!fs::exists(sensor_file) && fs::exists(camchain)) {
    return {camchain};
  }
  return {sensor_file, mav0 / "cam1" / "sensor.yaml"};
}

}  // namespace

bool IsEuroc(const fs::path& root) {
  return fs::is_directory(root / "mav0") || FolderPath(root).filename() == "mav0" ||
         fs::exists(root / "cam0" / "data.csv") || fs::exists(root / "cam1" / "data.csv");
}

Dataset OpenEuroc(const fs::path& root, const DatasetOptions& options) {
  const fs::path mav0 = Mav0(root);
  Dataset dataset;
  dataset.root = root;
  dataset.format = DatasetFormat::kEuroc;
  const std::map<int64_t, fs::path> left = ListCamera(mav0 / "cam0");
  const std::map<int64_t, fs::path> right = ListCamera(mav0 / "cam1");
  // A few images of either camera have no mate in the published sequences: they are left out.
  for (const auto& [timestamp_ns, image] : left) {
    if (const auto mate = right.find(timestamp_ns); mate != right.end()) {
      dataset.entries.push_back({timestamp_ns, {image, mate->second}});
    }
  }
  if (dataset.entries.empty()) {
    throw Error(mav0.string() + ": no image of cam0 has the same time as one of cam1");
  }
  SetCalibration(options.calibration ? CalibrationFiles(options) : OwnCalibration(mav0), dataset);
  const std::vector<fs::path> candidates = {mav0 / "state_groundtruth_estimate0" / "data.csv",
                                            mav0 / "mocap0" / "data.csv"};
  if (options.groundtruth) {
    dataset.groundtruth = ReadTrajectory(*options.groundtruth);
  } else {
    for (const fs::path& candidate : candidates) {
      if (!dataset.groundtruth && fs::exists(candidate)) {
        dataset.groundtruth = ReadTrajectory(candidate);
      }
    }
  }
  return dataset;
}

}  // namespace gluevo::vo
