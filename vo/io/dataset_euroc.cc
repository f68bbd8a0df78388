// EuRoC's ASL layout (Burri et al. 2016), and TUM-VI, which uses it with equidistant cameras.

#include <algorithm>
#include <set>
#include <system_error>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "image_pairs.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

fs::path Mav0(const fs::path& root) {
  return fs::is_directory(root / "mav0") ? root / "mav0" : root;
}

// The images that data.csv lists, in the order of their times; those that are missing are counted.
std::vector<KeyedImage> ListCamera(const fs::path& camera_folder, Dataset& dataset) {
  CheckFolder(camera_folder, "a camera of a EuRoC data set");
  const fs::path csv = camera_folder / "data.csv";
  std::vector<KeyedImage> images;
  std::vector<fs::path> missing;
  std::set<int64_t> times;
  for (const TextLine& line : ReadLines(csv, /*skip_comments=*/true)) {
    const auto fields = SplitFields(line.text, ',');
    const auto timestamp_ns = ParseInteger(fields[0]);
    if (fields.size() < 2 || !timestamp_ns || fields[1].empty()) {
      throw Error(At(csv, line) + ": expected \"timestamp [ns],filename\"");
    }
    if (!times.insert(*timestamp_ns).second) {
      throw Error(At(csv, line) + ": the time " + std::to_string(*timestamp_ns) +
                  " is there twice");
    }
    const fs::path image = camera_folder / "data" / std::string(fields[1]);
    std::error_code ignored;
    if (fs::is_regular_file(image, ignored)) {
      images.push_back({*timestamp_ns, image});
    } else {
      missing.push_back(image);
    }
  }
  if (images.empty() && !missing.empty()) {
    throw Error(missing.front().string() + ": no such image, and none of the others that " +
                csv.string() + " names");
  }
  if (!missing.empty()) {
    dataset.images_left_out += static_cast<int>(missing.size());
    dataset.warnings.push_back(std::to_string(missing.size()) + " images that " + csv.string() +
                               " names are missing (the first is " + missing.front().string() +
                               ")");
  }
  std::sort(images.begin(), images.end(),
            [](const KeyedImage& a, const KeyedImage& b) { return a.key < b.key; });
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
  const std::array<std::vector<KeyedImage>, 2> images = {ListCamera(mav0 / "cam0", dataset),
                                                         ListCamera(mav0 / "cam1", dataset)};
  // A few images of either camera have no mate in the published sequences: they are left out.
  const ImagePairs pairs = PairImages(images, PairTolerance(images, options), "time");
  for (const ImagePair& pair : pairs.pairs) {
    dataset.entries.push_back({pair.images[0].key, {pair.images[0].path, pair.images[1].path}});
  }
  if (dataset.entries.empty()) {
    throw Error(mav0.string() + ": no image of cam0 has the same time as one of cam1" +
                HowFarApart(pairs, /*stamped=*/true));
  }
  ReportPairs(pairs, /*stamped=*/true, dataset);
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
