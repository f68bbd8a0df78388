// KITTI odometry sequences and raw drives (Geiger et al. 2012 and 2013).

#include <Eigen/LU>
#include <cstdio>
#include <map>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "text_file.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

// The "KEY: numbers" lines of KITTI's calibration files; lines whose values are no numbers (dates)
// are left out.
class Calibration {
 public:
  explicit Calibration(fs::path path) : path_(std::move(path)) {
    for (const TextLine& line : ReadLines(path_, /*skip_comments=*/true)) {
      const std::size_t colon = line.text.find(':');
      if (colon == std::string::npos) {
        throw Error(At(path_, line) + ": expected \"KEY: numbers\"");
      }
      std::vector<double> numbers;
      bool all_numbers = true;
      for (const std::string_view field :
           SplitFields(std::string_view(line.text).substr(colon + 1), ' ')) {
        const auto number = ParseNumber(field);
        all_numbers = all_numbers && number;
        numbers.push_back(number.value_or(0.0));
      }
      if (all_numbers) {
        values_[line.text.substr(0, colon)] = std::move(numbers);
      }
    }
  }

  bool Has(const std::string& key) const { return values_.contains(key); }

  const std::vector<double>& Get(const std::string& key, std::size_t count) const {
    const auto found = values_.find(key);
    if (found == values_.end()) {
      throw Error(path_.string() + ": no " + key);
    }
    if (found->second.size() != count) {
      throw Error(path_.string() + ": " + key + " has " + std::to_string(found->second.size()) +
                  " numbers, expected " + std::to_string(count));
    }
    return found->second;
  }

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  std::map<std::string, std::vector<double>> values_;
};

// Two rectified cameras with the projections P = K [I | t]. The body is the left camera.
StereoRig RectifiedRig(const Calibration& calibration, const std::string& left_key,
                       const std::string& right_key, const std::array<int, 2>& size) {
  StereoRig rig;
  rig.body_frame = "left camera";
  std::array<Eigen::Vector3d, 2> offsets;  // Of a point's coordinates from the common frame.
  const std::array<std::string, 2> keys = {left_key, right_key};
  for (std::size_t side = 0; side < 2; ++side) {
    const std::vector<double>& p = calibration.Get(keys[side], 12);
    Camera& camera = rig.cameras[side];
    camera.width = size[0];
    camera.height = size[1];
    camera.fx = p[0];
    camera.fy = p[5];
    camera.cx = p[2];
    camera.cy = p[6];
    camera.Validate(calibration.path().string() + ", " + keys[side]);
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> projection(p.data());
    const Eigen::Matrix3d intrinsics = projection.leftCols<3>();
    offsets[side] = intrinsics.inverse() * projection.col(3);
  }
  rig.body_from_cam[1].translation = offsets[0] - offsets[1];
  return rig;
}

std::string SixDigits(std::size_t number) {
  char text[24];
  std::snprintf(text, sizeof(text), "%06zu", number);
  return text;
}

// Days since 1970-01-01 in the Gregorian calendar (Hinnant's algorithm).
int64_t DaysFromDate(int64_t year, int64_t month, int64_t day) {
  year -= month <= 2 ? 1 : 0;
  const int64_t era = (year >= 0 ? year : year - 399) / 400;
  const int64_t year_of_era = year - era * 400;
  const int64_t day_of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  const int64_t day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
  return era * 146097 + day_of_era - 719468;
}

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
  const auto year = ParseInteger(date[0]);
  const auto month = ParseInteger(date[1]);
  const auto day = ParseInteger(date[2]);
  const auto hour = ParseInteger(time[0]);
  const auto minute = ParseInteger(time[1]);
  const auto second_ns = ParseSeconds(time[2]);
  if (!year || !month || !day || !hour || !minute || !second_ns || *year < 1900 || *year > 2200 ||
      *month < 1 || *month > 12 || *day < 1 || *day > 31 || *hour < 0 || *hour > 23 ||
      *minute < 0 || *minute > 59 || *second_ns < 0) {
    return std::nullopt;
  }
  const int64_t seconds = DaysFromDate(*year, *month, *day) * 86400 + *hour * 3600 + *minute * 60;
  return seconds * 1'000'000'000 + *second_ns;
}

// One time a row, relative to the first.
std::vector<int64_t> ReadRawTimes(const fs::path& path) {
  std::vector<int64_t> times;
  for (const TextLine& line : ReadLines(path, /*skip_comments=*/true)) {
    const auto time = ParseDateTime(line.text);
    if (!time) {
      throw Error(At(path, line) + ": " + Quoted(line.text) +
                  " is not a time, expected YYYY-MM-DD HH:MM:SS.nnnnnnnnn");
    }
    times.push_back(*time);
  }
  for (std::size_t i = times.size(); i-- > 0;) {
    times[i] -= times[0];
  }
  return times;
}

fs::path FindRawCalibration(const fs::path& root) {
  fs::path folder = fs::absolute(root).lexically_normal();
  for (int level = 0; level < 4 && !folder.empty(); ++level) {
    if (fs::exists(folder / "calib_cam_to_cam.txt")) {
      return folder / "calib_cam_to_cam.txt";
    }
    // A path that ends in a slash has itself as parent.
    folder = folder.has_filename() ? folder.parent_path() : folder.parent_path().parent_path();
  }
  throw Error(root.string() + ": no calib_cam_to_cam.txt in it or in the three folders above it");
}

// The unrectified cameras 0 and 1. The body is the left camera.
StereoRig UnrectifiedRig(const Calibration& calibration, const std::array<int, 2>& size) {
  StereoRig rig;
  rig.body_frame = "left camera";
  std::array<Rigid3, 2> cam_from_reference;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string suffix = "_0" + std::to_string(side);
    const std::vector<double>& k = calibration.Get("K" + suffix, 9);
    const std::vector<double>& d = calibration.Get("D" + suffix, 5);
    const std::vector<double>& r = calibration.Get("R" + suffix, 9);
    const std::vector<double>& t = calibration.Get("T" + suffix, 3);
    Camera& camera = rig.cameras[side];
    camera.width = size[0];
    camera.height = size[1];
    camera.fx = k[0];
    camera.fy = k[4];
    camera.cx = k[2];
    camera.cy = k[5];
    camera.distortion = Distortion::kRadialTangential;
    std::copy(d.begin(), d.end(), camera.coefficients.begin());
    camera.Validate(calibration.path().string() + ", K" + suffix);
    cam_from_reference[side] =
        RigidFromRows({r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2]},
                      "R" + suffix, calibration.path());
  }
  rig.body_from_cam[1] = cam_from_reference[0] * cam_from_reference[1].Inverse();
  return rig;
}

bool IsSize(const Calibration& calibration, const std::string& key,
            const std::array<int, 2>& size) {
  if (!calibration.Has(key)) {
    return false;
  }
  const std::vector<double>& s = calibration.Get(key, 2);
  return static_cast<int>(s[0]) == size[0] && static_cast<int>(s[1]) == size[1];
}

}  // namespace

bool IsKittiOdometry(const fs::path& root) {
  return fs::is_directory(root / "image_0") && fs::exists(root / "calib.txt");
}

Dataset OpenKittiOdometry(const fs::path& root, const DatasetOptions& options) {
  Dataset dataset;
  dataset.root = root;
  dataset.format = DatasetFormat::kKittiOdometry;
  const std::array<fs::path, 2> folders = {root / "image_0", root / "image_1"};
  for (const fs::path& folder : folders) {
    CheckFolder(folder, "a camera of a KITTI sequence");
  }
  const std::vector<int64_t> times = ReadTimes(root / "times.txt");
  const Calibration calibration(root / "calib.txt");
  const std::string extension = fs::exists(folders[0] / "000000.jpg") ? ".jpg" : ".png";
  for (std::size_t i = 0; i < times.size(); ++i) {
    const std::string name = SixDigits(i) + extension;
    dataset.entries.push_back({times[i], {folders[0] / name, folders[1] / name}});
    CheckImageFile(dataset.entries.back().images[0]);
    CheckImageFile(dataset.entries.back().images[1]);
  }
  if (dataset.entries.empty()) {
    throw Error((root / "times.txt").string() + ": no times");
  }
  dataset.rig = RectifiedRig(calibration, "P0", "P1", ImageSize(dataset.entries.front().images[0]));

  const fs::path sequence = fs::absolute(root).lexically_normal();
  const fs::path name =
      sequence.has_filename() ? sequence.filename() : sequence.parent_path().filename();
  const fs::path default_groundtruth =
      (sequence.has_filename() ? sequence : sequence.parent_path()).parent_path().parent_path() /
      "poses" / (name.string() + ".txt");
  if (options.groundtruth) {
    dataset.groundtruth =
        RecognizeTrajectoryFormat(*options.groundtruth) == TrajectoryFormat::kKitti
            ? ReadKittiTrajectory(*options.groundtruth, times)
            : ReadTrajectory(*options.groundtruth);
  } else if (fs::exists(default_groundtruth)) {
    dataset.groundtruth = ReadKittiTrajectory(default_groundtruth, times);
  }
  return dataset;
}

bool IsKittiRaw(const fs::path& root) { return fs::is_directory(root / "image_00" / "data"); }

Dataset OpenKittiRaw(const fs::path& root, const DatasetOptions& options) {
  Dataset dataset;
  dataset.root = root;
  dataset.format = DatasetFormat::kKittiRaw;
  const std::array<fs::path, 2> folders = {root / "image_00" / "data", root / "image_01" / "data"};
  for (const fs::path& folder : folders) {
    CheckFolder(folder, "a camera of a KITTI drive");
  }
  // Of one camera, or of the drive.
  const fs::path camera_times = root / "image_00" / "timestamps.txt";
  const fs::path times_file = fs::exists(camera_times) ? camera_times : root / "timestamps.txt";
  const std::vector<int64_t> times = ReadRawTimes(times_file);
  for (const fs::path& image : ListImages(folders[0])) {
    const auto number = ParseInteger(image.stem().string());
    if (!number || *number < 0) {
      throw Error(image.string() + ": the name of an image of a drive is its number");
    }
    if (static_cast<std::size_t>(*number) >= times.size()) {
      throw Error(image.string() + ": " + times_file.string() + " has no row " +
                  std::to_string(*number) + ", only " + std::to_string(times.size()) + " rows");
    }
    const fs::path mate = folders[1] / image.filename();
    CheckImageFile(mate);
    dataset.entries.push_back({times[static_cast<std::size_t>(*number)], {image, mate}});
  }
  if (dataset.entries.empty()) {
    throw Error(folders[0].string() + ": no images");
  }

  const Calibration calibration(FindRawCalibration(root));
  const std::array<int, 2> size = ImageSize(dataset.entries.front().images[0]);
  if (IsSize(calibration, "S_rect_00", size)) {
    dataset.rig = RectifiedRig(calibration, "P_rect_00", "P_rect_01", size);
  } else if (IsSize(calibration, "S_00", size)) {
    dataset.rig = UnrectifiedRig(calibration, size);
  } else {
    throw Error(dataset.entries.front().images[0].string() + ": an image of " +
                std::to_string(size[0]) + " x " + std::to_string(size[1]) +
                " pixels, expected S_00 (unrectified) or S_rect_00 (rectified) of " +
                calibration.path().string());
  }
  if (options.groundtruth) {
    dataset.groundtruth = ReadTrajectory(*options.groundtruth);
  }
  return dataset;
}

}  // namespace gluevo::vo
