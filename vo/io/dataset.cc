#include "gluevo/vo/io/dataset.h"

#include <algorithm>
#include <iterator>
#include <system_error>

#include "dataset_formats.h"
#include "foreign_input.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/vo/io/image_file.h"
#include "imu_faults.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

struct Format {
  bool (*is)(const fs::path& root);
  Dataset (*open)(const fs::path& root, const DatasetOptions& options);
  DatasetFormat name;
  bool takes_calibration;
};

// In the order in which they are recognised.
constexpr Format kFormats[] = {
    {&IsEuroc, &OpenEuroc, DatasetFormat::kEuroc, true},
    {&IsKittiOdometry, &OpenKittiOdometry, DatasetFormat::kKittiOdometry, false},
    {&IsKittiRaw, &OpenKittiRaw, DatasetFormat::kKittiRaw, false},
    {&IsPlain, &OpenPlain, DatasetFormat::kPlain, true},
};

// Of folders that nobody named, and that may not be ours to read.
bool IsDataset(const fs::path& folder) {
  try {
    return fs::is_directory(folder) &&
           std::any_of(std::begin(kFormats), std::end(kFormats),
                       [&](const Format& format) { return format.is(folder); });
  } catch (const std::exception&) {
    return false;
  }
}

std::vector<fs::path> SortedEntries(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code code;
  for (auto entry = fs::directory_iterator(folder, code);
       !code && entry != fs::directory_iterator(); entry.increment(code)) {
    entries.push_back(entry->path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

// The data set that was meant, where it lies in the folder that was named, or that one in it.
std::string DidYouMean(const fs::path& root) {
  std::vector<fs::path> folders = SortedEntries(root);
  const std::size_t below = folders.size();
  // Collections have a few folders of sequences.
  constexpr std::size_t kMostSearched = 30;
  for (std::size_t i = 0; i < std::min(below, kMostSearched); ++i) {
    const std::vector<fs::path> inner = SortedEntries(folders[i]);
    folders.insert(
        folders.end(), inner.begin(),
        inner.begin() + static_cast<std::ptrdiff_t>(std::min(inner.size(), kMostSearched)));
  }
  const fs::path above = FolderPath(root).parent_path();
  folders.push_back(above);
  folders.push_back(above.parent_path());
  folders.push_back(above.parent_path().parent_path());
  for (const fs::path& folder : folders) {
    const bool hidden = folder.filename().string().starts_with('.');
    if (!hidden && folder != folder.root_path() && IsDataset(folder)) {
      return "; did you mean " + folder.string() + "?";
    }
  }
  return "";
}

const Format& FormatOf(const fs::path& root, const DatasetOptions& options) {
  const auto* const found =
      std::find_if(std::begin(kFormats), std::end(kFormats), [&](const Format& format) {
        return options.format ? format.name == *options.format : format.is(root);
      });
  if (found == std::end(kFormats)) {
    throw Error(root.string() +
                ": no data set that is known: looked for mav0 or cam0/data.csv (EuRoC, TUM-VI), "
                "image_0 and calib.txt (KITTI odometry), image_00/data (KITTI raw), left and "
                "right, cam0 and cam1 or image_0 and image_1 (plain)" +
                DidYouMean(root) + ForeignFilesIn(root));
  }
  return *found;
}

void CheckIsFolder(const fs::path& path) {
  std::error_code ignored;
  if (fs::exists(path, ignored) && !fs::is_directory(path, ignored)) {
    throw Error(path.string() + ": " + WhatFileIs(path) +
                ", not a folder: a data set is a folder of images (extract those of a recording or "
                "an archive first)");
  }
  CheckFolder(path, "data set");
}

// Looked at are all images, whichever are chosen: the same bits for each choice.
void LookAtImages(Dataset& dataset) {
  std::vector<fs::path> images;
  images.reserve(2 * dataset.entries.size());
  for (const Dataset::Entry& entry : dataset.entries) {
    images.insert(images.end(), entry.images.begin(), entry.images.end());
  }
  dataset.gray_bits = GrayBits(images);
  constexpr int kAllBits = 16;
  if (dataset.gray_bits < kAllBits) {
    dataset.notes.push_back("the 16-bit images hold values of " +
                            std::to_string(dataset.gray_bits) +
                            " bits, which are taken for the whole range from black to white");
  }
  for (std::size_t i = 0; i < std::min<std::size_t>(images.size(), 2); ++i) {
    if (ImageOrientation(images[i]) != 1) {
      dataset.notes.push_back(images[i].string() +
                              ": the file asks to be turned (EXIF), which is never done: a "
                              "calibration is of images as they are stored");
      return;
    }
  }
}

Dataset OpenAll(const fs::path& root, const DatasetOptions& options) {
  const Format& format = FormatOf(root, options);
  if (options.rate_hz && format.name != DatasetFormat::kPlain) {
    throw Error(root.string() + ": has its own times: --rate is for plain data sets without any");
  }
  if (options.calibration && !format.takes_calibration) {
    throw Error(root.string() +
                ": a KITTI data set has its own calibration: --calibration is for plain (--format "
                "plain) and EuRoC data sets");
  }
  if ((options.imu || options.imu_calibration) && !format.takes_calibration) {
    throw Error(root.string() +
                (format.name == DatasetFormat::kKittiRaw
                     ? ": a KITTI raw data set has its own inertial readings (oxts), which take no "
                       "others"
                     : ": KITTI's odometry data set has no inertial unit and no place for one's "
                       "readings: expected no --imu FILE and no --imu-calibration"));
  }
  return format.open(root, options);
}

}  // namespace

void DatasetOptions::Validate() const {
  if (start < 0) {
    throw OptionError("first frame " + std::to_string(start) + " is negative (--start)");
  }
  if (count < -1 || count == 0) {
    throw OptionError("number of frames " + std::to_string(count) +
                      " is out of range: expected at least 1 (--count)");
  }
  if (stride < 1) {
    throw OptionError("stride " + std::to_string(stride) +
                      " is out of range: expected at least 1 (--stride)");
  }
  if (rate_hz && !(*rate_hz >= 1e-3 && *rate_hz <= 1e6)) {
    throw OptionError("rate " + std::to_string(*rate_hz) +
                      " is out of range: expected 0.001 to 1e6 images a second (--rate)");
  }
  constexpr double kLongest = 1e6;
  if (pair_tolerance_s && !(*pair_tolerance_s >= 0.0 && *pair_tolerance_s <= kLongest)) {
    throw OptionError("pair tolerance " + std::to_string(*pair_tolerance_s) +
                      " is out of range: expected seconds, at least 0 (--pair-tolerance)");
  }
}

StereoFrame Dataset::Read(std::size_t index) const {
  const Entry& entry = entries.at(index);
  StereoFrame frame;
  frame.timestamp_ns = entry.timestamp_ns;
  for (std::size_t side = 0; side < 2; ++side) {
    frame.images[side] = ReadGrayImage(entry.images[side], gray_bits).pixels;
    const cv::Mat& image = frame.images[side];
    const Camera& camera = rig.cameras[side];
    if (image.cols != camera.width || image.rows != camera.height) {
      throw Error(
          WrongSizeMessage(entry.images[side], {image.cols, image.rows}, camera, calibration));
    }
  }
  return frame;
}

Dataset OpenDataset(const fs::path& path, const DatasetOptions& options) {
  options.Validate();
  CheckIsFolder(path);
  Dataset dataset = OpenAll(path, options);
  LookAtImages(dataset);
  if (dataset.entries.empty()) {
    throw Error(path.string() + ": a data set without a stereo pair");
  }
  CheckCalibration(dataset);
  if (static_cast<std::size_t>(options.start) >= dataset.entries.size()) {
    throw OptionError("first frame " + std::to_string(options.start) + " is beyond the last of " +
                      path.string() + " (--start); expected at most " +
                      std::to_string(dataset.entries.size() - 1));
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
  if (dataset.imu) {
    std::vector<int64_t> times_ns;
    times_ns.reserve(dataset.entries.size());
    for (const Dataset::Entry& entry : dataset.entries) {
      times_ns.push_back(entry.timestamp_ns);
    }
    CheckCoverage(times_ns, *dataset.imu);
  }
  return dataset;
}

void CheckFolder(const fs::path& folder, const std::string& what) {
  if (!fs::is_directory(folder)) {
    throw Error(folder.string() + ": no such folder (" + what + ")");
  }
}

std::array<int, 2> ImageSize(const fs::path& file) {
  const cv::Mat image = ReadGrayImage(file).pixels;
  return {image.cols, image.rows};
}

std::array<int, 2> FirstImageSize(const Dataset& dataset) {
  constexpr std::size_t kTried = 100;
  std::string message;
  for (std::size_t i = 0; i < std::min(kTried, dataset.entries.size()); ++i) {
    try {
      return ImageSize(dataset.entries[i].images[0]);
    } catch (const Error& error) {
      message = message.empty() ? error.what() : message;
    }
  }
  throw Error("none of the first " + std::to_string(std::min(kTried, dataset.entries.size())) +
              " left images can be read: " + message);
}

fs::path FolderPath(const fs::path& folder) {
  const fs::path path = fs::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace gluevo::vo
