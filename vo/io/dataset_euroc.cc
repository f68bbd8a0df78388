// EuRoC's ASL layout (Burri et al. 2016), and TUM-VI, which uses it with equidistant cameras.

#include <algorithm>
#include <set>
#include <system_error>

#include "calibration_parts.h"
#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/core/steps.h"
#include "gluevo/vo/core/text.h"
#include "groundtruth.h"
#include "image_pairs.h"
#include "imu_source.h"
#include "stamp_unit.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

fs::path Mav0(const fs::path& root) {
  return fs::is_directory(root / "mav0") ? root / "mav0" : root;
}

struct Row {
  TextLine line;
  std::string time;
  std::string image;
};

std::vector<Row> ReadRows(const fs::path& csv) {
  std::vector<Row> rows;
  for (const TextLine& line : ReadTable(csv)) {
    const auto fields = SplitFields(line.text, ',');
    if (fields.size() < 2 || !ParseNumber(fields[0]) || fields[1].empty()) {
      throw Error(At(csv, line) + ": expected \"timestamp [ns],filename\"");
    }
    rows.push_back({line, std::string(fields[0]), std::string(fields[1])});
  }
  return rows;
}

// Nanoseconds, but where the times are none: people who write such files heed no more than names.
StampUnit UnitOf(const std::vector<Row>& rows) {
  std::vector<int64_t> integers;
  double largest = 0.0;
  for (const Row& row : rows) {
    largest = std::max(largest, ParseNumber(row.time).value_or(0.0));
    if (const std::optional<int64_t> integer = ParseInteger(row.time)) {
      integers.push_back(*integer);
    }
  }
  if (integers.size() < rows.size()) {
    return UnitOfDecimals(largest);
  }
  constexpr StampUnit kNanoseconds = 9;
  constexpr int64_t kShortestMicroseconds = 5000;
  const int64_t step = MedianStep(integers);
  return UnitSince1970(integers).value_or(step < kShortestMicroseconds ? kNanoseconds
                                                                       : UnitOfStep(step));
}

// The images that data.csv lists, in the order of their times; those that are missing are counted.
std::vector<KeyedImage> ListCamera(const fs::path& camera_folder, Dataset& dataset) {
  CheckFolder(camera_folder, "a camera of a EuRoC data set");
  const fs::path csv = camera_folder / "data.csv";
  std::vector<KeyedImage> images;
  std::vector<fs::path> missing;
  std::set<int64_t> times;
  const std::vector<Row> rows = ReadRows(csv);
  const StampUnit unit = UnitOf(rows);
  constexpr StampUnit kNanoseconds = 9;
  if (unit != kNanoseconds) {
    dataset.notes.push_back("the times in " + csv.string() + " are in " + UnitName(unit));
  }
  for (const Row& row : rows) {
    const auto timestamp_ns = DecimalInNanoseconds(row.time, unit);
    if (!timestamp_ns) {
      throw Error(At(csv, row.line) + ": " + Quoted(row.time) + " is not a time in " +
                  UnitName(unit));
    }
    if (!times.insert(*timestamp_ns).second) {
      const bool few_digits = row.time.find_first_of("eE") != std::string::npos;
      throw Error(At(csv, row.line) + ": the time " + row.time + " is there twice" +
                  (few_digits ? ": it has too few digits, expected all of them" : ""));
    }
    const fs::path image = camera_folder / "data" / row.image;
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
    dataset.warnings.push_back(Counted(missing.size(), "image") + " that " + csv.string() +
                               " names missing (the first is " + missing.front().string() + ")");
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

// A calibration of the cameras alone does not tell where they are on the body, whose path the data
// set's ground truth is.
void PutOnBody(const fs::path& sensor_file, Dataset& dataset) {
  std::error_code ignored;
  if (dataset.rig.body_frame != "left camera" || !fs::exists(sensor_file, ignored)) {
    return;
  }
  const CalibrationFile file = ParseCalibrationFile(sensor_file, ReadText(sensor_file));
  if (!file.Has("T_BS")) {
    return;
  }
  Calibration calibration;
  const Rigid3 body_from_left = TransformFromYaml(file.tree, "T_BS", file.path, calibration);
  const Rigid3 body_from_reference = body_from_left * dataset.rig.body_from_cam[0].Inverse();
  for (Rigid3& body_from_cam : dataset.rig.body_from_cam) {
    body_from_cam = body_from_reference * body_from_cam;
  }
  dataset.rig.body_frame = "imu (body)";
  dataset.notes.push_back("where the left camera is on the body is from " + sensor_file.string() +
                          ": the calibration that was named has the cameras alone");
}

}  // namespace

bool IsEuroc(const fs::path& root) {
  return fs::is_directory(root / "mav0") || FolderPath(root).filename() == "mav0" ||
         (fs::exists(root / "cam0" / "data.csv") && fs::is_directory(root / "cam0" / "data")) ||
         (fs::exists(root / "cam1" / "data.csv") && fs::is_directory(root / "cam1" / "data"));
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
  PutOnBody(mav0 / "cam0" / "sensor.yaml", dataset);
  const std::vector<fs::path> candidates = {mav0 / "state_groundtruth_estimate0" / "data.csv",
                                            mav0 / "mocap0" / "data.csv"};
  AddGroundtruth(options, candidates, {}, dataset);
  AddImu(options, EurocImuFiles(mav0), dataset);
  return dataset;
}

}  // namespace gluevo::vo
