#include "gluevo/vo/io/dataset.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/calibration.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

std::vector<unsigned char> ReadBytes(const fs::path& path) {
  CheckImageFile(path);
  std::ifstream file(path, std::ios::binary);
  std::vector<unsigned char> bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file) {
    throw Error(path.string() + ": cannot be read");
  }
  return bytes;
}

/// Decoders fill the rest of a JPEG file that is cut off with gray and call it read.
bool IsCutOffJpeg(const std::vector<unsigned char>& bytes) {
  constexpr std::array<unsigned char, 2> kBegin = {0xFF, 0xD8};
  constexpr std::array<unsigned char, 2> kEnd = {0xFF, 0xD9};
  return bytes.size() >= kBegin.size() && std::equal(kBegin.begin(), kBegin.end(), bytes.begin()) &&
         std::find_end(bytes.begin(), bytes.end(), kEnd.begin(), kEnd.end()) == bytes.end();
}

cv::Mat ReadGray(const fs::path& path) {
  const std::vector<unsigned char> bytes = ReadBytes(path);
  cv::Mat image;
  if (!bytes.empty() && !IsCutOffJpeg(bytes)) {
    try {
      image = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {
      image.release();
    }
  }
  if (image.empty() || image.type() != CV_8UC1) {
    throw Error(path.string() + ": not an image, or cut off");
  }
  return image;
}

struct Format {
  DatasetFormat name;
  bool (*is)(const fs::path& root);
  Dataset (*open)(const fs::path& root, const DatasetOptions& options);
  bool takes_calibration;
};

// In the order in which they are recognised.
constexpr Format kFormats[] = {
    {DatasetFormat::kEuroc, &IsEuroc, &OpenEuroc, true},
    {DatasetFormat::kKittiOdometry, &IsKittiOdometry, &OpenKittiOdometry, false},
    {DatasetFormat::kKittiRaw, &IsKittiRaw, &OpenKittiRaw, false},
    {DatasetFormat::kPlain, &IsPlain, &OpenPlain, true},
};

const Format& FormatOf(const fs::path& root, const DatasetOptions& options) {
  const auto* const found =
      std::find_if(std::begin(kFormats), std::end(kFormats), [&](const Format& format) {
        return options.format ? format.name == *options.format : format.is(root);
      });
  if (found == std::end(kFormats)) {
    throw Error(root.string() +
                ": no data set that is known: looked for mav0 or cam0/data.csv (EuRoC, TUM-VI), "
                "image_0 and calib.txt (KITTI odometry), image_00/data (KITTI raw), left and "
                "right, cam0 and cam1 or image_0 and image_1 (plain)");
  }
  return *found;
}

std::string SizeMessage(const fs::path& image, const std::array<int, 2>& size, const Camera& camera,
                        const fs::path& calibration) {
  return image.string() + ": an image of " + std::to_string(size[0]) + " x " +
         std::to_string(size[1]) + " pixels, expected " + std::to_string(camera.width) + " x " +
         std::to_string(camera.height) +
         (calibration.empty() ? "" : ", the size in the calibration " + calibration.string());
}

/// The size of an image; nothing where it cannot be read, which is for the one who needs it to say.
std::optional<std::array<int, 2>> SizeIfReadable(const fs::path& image) {
  try {
    return ImageSize(image);
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// One odd image among others is for Read to refuse; here it is the first, the last and one
/// between.
void CheckImageSizes(const Dataset& dataset) {
  std::string message;
  const std::size_t count = dataset.entries.size();
  for (const std::size_t i : {std::size_t{0}, count / 2, count - 1}) {
    const Dataset::Entry& entry = dataset.entries[i];
    for (std::size_t side = 0; side < 2; ++side) {
      const Camera& camera = dataset.rig.cameras[side];
      const std::optional<std::array<int, 2>> size = SizeIfReadable(entry.images[side]);
      if (!size) {
        continue;
      }
      if (*size == std::array{camera.width, camera.height}) {
        return;
      }
      message = message.empty()
                    ? SizeMessage(entry.images[side], *size, camera, dataset.calibration)
                    : message;
    }
  }
  if (!message.empty()) {
    throw Error(message);
  }
}

Dataset OpenAll(const fs::path& root, const DatasetOptions& options) {
  const Format& format = FormatOf(root, options);
  if (options.calibration && !format.takes_calibration) {
    throw Error(root.string() +
                ": a KITTI data set has its own calibration: --calibration is for plain (--format "
                "plain) and EuRoC data sets");
  }
  return format.open(root, options);
}

}  // namespace

void DatasetOptions::Validate() const {
  if (start < 0) {
    throw Error("first frame " + std::to_string(start) + " is negative (--start)");
  }
  if (count < -1 || count == 0) {
    throw Error("number of frames " + std::to_string(count) +
                " is out of range: expected at least 1 (--count)");
  }
  if (stride < 1) {
    throw Error("stride " + std::to_string(stride) +
                " is out of range: expected at least 1 (--stride)");
  }
}

StereoFrame Dataset::Read(std::size_t index) const {
  const Entry& entry = entries.at(index);
  StereoFrame frame;
  frame.timestamp_ns = entry.timestamp_ns;
  for (std::size_t side = 0; side < 2; ++side) {
    frame.images[side] = ReadGray(entry.images[side]);
    const cv::Mat& image = frame.images[side];
    const Camera& camera = rig.cameras[side];
    if (image.cols != camera.width || image.rows != camera.height) {
      throw Error(SizeMessage(entry.images[side], {image.cols, image.rows}, camera, calibration));
    }
  }
  return frame;
}

Dataset OpenDataset(const fs::path& path, const DatasetOptions& options) {
  options.Validate();
  CheckFolder(path, "data set");
  Dataset dataset = OpenAll(path, options);
  if (dataset.entries.empty()) {
    throw Error(path.string() + ": a data set without a stereo pair");
  }
  dataset.rig.Validate(dataset.calibration.empty() ? path.string() : dataset.calibration.string());
  CheckImageSizes(dataset);
  if (static_cast<std::size_t>(options.start) >= dataset.entries.size()) {
    throw Error("first frame " + std::to_string(options.start) + " is beyond the last, " +
                std::to_string(dataset.entries.size() - 1) + ", of " + path.string() +
                " (--start)");
  }
  std::vector<Dataset::Entry> chosen;
  const auto wanted =
      options.count < 0 ? dataset.entries.size() : static_cast<std::size_t>(options.count);
  for (auto i = static_cast<std::size_t>(options.start);
       i < dataset.entries.size() && chosen.size() < wanted;
       i += static_cast<std::size_t>(options.stride)) {
    chosen.push_back(dataset.entries[i]);
  }
  dataset.entries = std::move(chosen);
  for (std::size_t i = 1; i < dataset.entries.size(); ++i) {
    if (dataset.entries[i].timestamp_ns <= dataset.entries[i - 1].timestamp_ns) {
      throw Error(dataset.entries[i].images[0].string() +
                  ": its time is not after that of the image before");
    }
  }
  return dataset;
}

std::vector<fs::path> CalibrationFiles(const DatasetOptions& options) {
  std::vector<fs::path> files;
  for (const auto& file : {options.calibration, options.calibration_mate}) {
    if (file) {
      files.push_back(*file);
    }
  }
  return files;
}

void SetCalibration(const std::vector<fs::path>& files, Dataset& dataset) {
  std::optional<std::array<int, 2>> size;
  constexpr std::size_t kMostTries = 5;
  for (std::size_t i = 0; i < std::min(kMostTries, dataset.entries.size()) && !size; ++i) {
    size = SizeIfReadable(dataset.entries[i].images[0]);
  }
  const Calibration calibration = ReadCalibration(files, size);
  dataset.rig = calibration.rig;
  dataset.calibration = calibration.files.front();
  for (const std::string& warning : calibration.warnings) {
    dataset.warnings.push_back(dataset.calibration.string() + ": " + warning);
  }
}

void CheckFolder(const fs::path& folder, const std::string& what) {
  if (!fs::is_directory(folder)) {
    throw Error(folder.string() + ": no such folder (" + what + ")");
  }
}

void CheckImageFile(const fs::path& file) {
  if (!fs::is_regular_file(file)) {
    throw Error(file.string() + ": no such image");
  }
}

std::vector<fs::path> ListImages(const fs::path& folder) {
  constexpr const char* kExtensions[] = {".png", ".jpg", ".jpeg", ".pgm", ".bmp", ".tif", ".tiff"};
  std::vector<fs::path> images;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool hidden = entry.path().filename().string().starts_with('.');
    if (!hidden && entry.is_regular_file() &&
        std::find(std::begin(kExtensions), std::end(kExtensions), extension) !=
            std::end(kExtensions)) {
      images.push_back(entry.path());
    }
  }
  std::sort(images.begin(), images.end());
  return images;
}

std::array<int, 2> ImageSize(const fs::path& file) {
  const cv::Mat image = ReadGray(file);
  return {image.cols, image.rows};
}

fs::path FolderPath(const fs::path& folder) {
  const fs::path path = fs::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace gluevo::vo
