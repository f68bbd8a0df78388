// Two folders of images that pair by name, with a calibration file.

#include <algorithm>
#include <set>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

std::optional<std::array<fs::path, 2>> FindFolders(const fs::path& root) {
  constexpr const char* kNames[][2] = {
      {"left", "right"}, {"cam0", "cam1"}, {"image_0", "image_1"}, {"image_00", "image_01"}};
  for (const auto& [left, right] : kNames) {
    if (fs::is_directory(root / left) && fs::is_directory(root / right)) {
      std::array<fs::path, 2> folders = {root / left, root / right};
      for (fs::path& folder : folders) {
        folder = fs::is_directory(folder / "data") ? folder / "data" : folder;
      }
      return folders;
    }
  }
  return std::nullopt;
}

// Nanoseconds of 16 digits or more, or decimal seconds with a point.
std::optional<int64_t> TimeFromName(const fs::path& image) {
  constexpr std::size_t kFewestDigits = 16;
  const std::string stem = image.stem().string();
  if (stem.find('.') != std::string::npos) {
    return ParseSeconds(stem);
  }
  return stem.size() >= kFewestDigits ? ParseInteger(stem) : std::nullopt;
}

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Names in the order people number them: "2" before "10".
bool NumbersBefore(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (!IsDigit(a[i]) || !IsDigit(b[j])) {
      if (a[i] != b[j]) {
        return a[i] < b[j];
      }
      ++i;
      ++j;
      continue;
    }
    const auto number = [](const std::string& text, std::size_t& position) {
      const std::size_t begin = std::min(text.find_first_not_of('0', position), text.size());
      for (position = begin; position < text.size() && IsDigit(text[position]);) {
        ++position;
      }
      return text.substr(begin, position - begin);
    };
    const std::string first = number(a, i);
    const std::string second = number(b, j);
    if (first != second) {
      return first.size() != second.size() ? first.size() < second.size() : first < second;
    }
  }
  // Equal so far: the shorter one, else ("1" and "01") any fixed order.
  return a.size() - i != b.size() - j ? a.size() - i < b.size() - j : a < b;
}

// Times from names where all of them are times; else ten pairs a second, in the order of names.
std::vector<Dataset::Entry> WithTimes(const std::vector<std::array<fs::path, 2>>& pairs) {
  constexpr int64_t kTenthOfSecondNs = 100'000'000;
  std::vector<Dataset::Entry> entries;
  for (const std::array<fs::path, 2>& pair : pairs) {
    if (const std::optional<int64_t> time = TimeFromName(pair[0])) {
      entries.push_back({*time, pair});
    }
  }
  if (entries.size() == pairs.size()) {
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Dataset::Entry& a, const Dataset::Entry& b) {
                       return a.timestamp_ns < b.timestamp_ns;
                     });
    return entries;
  }
  entries.clear();
  for (const std::array<fs::path, 2>& pair : pairs) {
    entries.push_back({0, pair});
  }
  std::sort(entries.begin(), entries.end(), [](const Dataset::Entry& a, const Dataset::Entry& b) {
    return NumbersBefore(a.images[0].filename().string(), b.images[0].filename().string());
  });
  for (std::size_t i = 0; i < entries.size(); ++i) {
    entries[i].timestamp_ns = static_cast<int64_t>(i) * kTenthOfSecondNs;
  }
  return entries;
}

}  // namespace

bool IsPlain(const fs::path& root) { return FindFolders(root).has_value(); }

Dataset OpenPlain(const fs::path& root, const DatasetOptions& options) {
  const auto folders = FindFolders(root);
  if (!folders) {
    throw Error(root.string() +
                ": no two folders of images in it, expected left and right, cam0 and cam1, "
                "image_0 and image_1, or image_00 and image_01");
  }
  if (!options.calibration) {
    throw Error(root.string() + ": a plain data set needs a calibration file (--calibration)");
  }
  Dataset dataset;
  dataset.root = root;
  dataset.format = DatasetFormat::kPlain;
  std::set<fs::path> right_names;
  for (const fs::path& image : ListImages((*folders)[1])) {
    right_names.insert(image.filename());
  }
  // As in EuRoC's sequences, an image without a mate is left out.
  std::vector<std::array<fs::path, 2>> pairs;
  for (const fs::path& image : ListImages((*folders)[0])) {
    if (right_names.contains(image.filename())) {
      pairs.push_back({image, (*folders)[1] / image.filename()});
    }
  }
  if (pairs.empty()) {
    throw Error((*folders)[0].string() + ": no image has a mate of the same name in " +
                (*folders)[1].string());
  }
  dataset.entries = WithTimes(pairs);
  SetCalibration(CalibrationFiles(options), dataset);
  if (options.groundtruth) {
    dataset.groundtruth = ReadTrajectory(*options.groundtruth);
  }
  return dataset;
}

}  // namespace gluevo::vo
