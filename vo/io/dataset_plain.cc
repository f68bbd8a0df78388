// Images of two cameras in folders of anybody's making, with a calibration file.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/core/text.h"
#include "groundtruth.h"
#include "image_names.h"
#include "image_pairs.h"
#include "imu_source.h"
#include "plain_images.h"
#include "times_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr double kAssumedRateHz = 10.0;

using KeyedImages = std::vector<KeyedImage>;

int64_t FirstKey(const ImageNames& names) {
  return std::min(names.images[0].front().key, names.images[1].front().key);
}

// The step from each image to the next where none is missing: 10 where every tenth was kept.
int64_t NumberStep(const ImageNames& names) {
  int64_t step = 0;
  for (const KeyedImages& images : names.images) {
    for (const KeyedImage& image : images) {
      step = std::gcd(step, image.key - FirstKey(names));
    }
  }
  return std::max<int64_t>(step, 1);
}

// Where images are fewer than rows without names, and numbers may count from 0 or from 1.
void NoteFirstRow(const TimesFile& times, const KeyedImages& images, KeyKind kind,
                  int64_t first_number, Dataset& dataset) {
  if (kind != KeyKind::kNumbers || first_number != 1 || !times.rows.front().image.empty() ||
      times.rows.size() <= images.size() ||
      static_cast<int64_t>(times.rows.size()) <= images.back().key + 1) {
    return;
  }
  dataset.warnings.push_back(times.path.string() + " has " + std::to_string(times.rows.size()) +
                             " times for " + std::to_string(images.size()) +
                             " images: image number n is given time number n, counted from 0 (if "
                             "the first time is that of image 1, remove the others)");
}

// Takes the times of a file for the keys of one camera; what has none is left out.
void TakeTimes(const TimesFile& times, ImageNames& names, std::size_t side, int64_t first_number,
               Dataset& dataset) {
  KeyedImages& images = names.images[side];
  const auto found = TimesOfImages(times, images, names.kind, first_number);
  KeyedImages timed;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (found[i]) {
      timed.push_back({*found[i], images[i].path});
    }
  }
  NoteFirstRow(times, images, names.kind, first_number, dataset);
  const std::size_t without = images.size() - timed.size();
  if (without > 0) {
    dataset.images_left_out += static_cast<int>(without);
    dataset.warnings.push_back(std::to_string(without) + " of " + std::to_string(images.size()) +
                               " images of " + images.front().path.parent_path().string() +
                               " have no time in " + times.path.string() + " and are left out");
  }
  std::sort(timed.begin(), timed.end(), [](const KeyedImage& a, const KeyedImage& b) {
    return a.key != b.key ? a.key < b.key : a.path < b.path;
  });
  images = std::move(timed);
}

void NoteTimes(const TimesFile& times, Dataset& dataset) {
  dataset.notes.push_back("the times are those of " + times.path.string() +
                          (times.unit.empty() ? "" : ", in " + times.unit));
}

void AddEntries(const ImagePairs& pairs, Dataset& dataset) {
  for (const ImagePair& pair : pairs.pairs) {
    dataset.entries.push_back({pair.images[0].key, {pair.images[0].path, pair.images[1].path}});
  }
}

ImagePairs Pair(const ImageNames& names, bool stamped, const DatasetOptions& options,
                Dataset& dataset) {
  ImagePairs pairs = PairImages(names.images, stamped ? PairTolerance(names.images, options) : 0,
                                stamped                           ? "time"
                                : names.kind == KeyKind::kNumbers ? "number"
                                                                  : "name");
  if (pairs.pairs.empty()) {
    const auto folder = [&](std::size_t side) {
      return names.images[side].empty() ? std::string("the other camera")
                                        : names.images[side].front().path.parent_path().string();
    };
    const char* const same = stamped                           ? "a time near that of"
                             : names.kind == KeyKind::kNumbers ? "the same number as"
                                                               : "the same name as";
    throw Error(folder(0) + ": no image has " + same + " one in " + folder(1) +
                HowFarApart(pairs, stamped));
  }
  ReportPairs(pairs, stamped, dataset);
  return pairs;
}

void WarnOfUnusedRate(const DatasetOptions& options, Dataset& dataset) {
  if (options.rate_hz) {
    dataset.warnings.emplace_back("--rate is not used: the data set has times");
  }
}

// Times of the names, or of a file for each camera: images pair by them.
void AddStamped(const ImageNames& names, const DatasetOptions& options, Dataset& dataset) {
  WarnOfUnusedRate(options, dataset);
  AddEntries(Pair(names, /*stamped=*/true, options, dataset), dataset);
}

// Images pair by number or name, and have the times of a file for both or for the left camera.
void AddTimed(ImageNames names, const TimesFile& times, const DatasetOptions& options,
              Dataset& dataset) {
  WarnOfUnusedRate(options, dataset);
  const int64_t first_number = FirstKey(names);
  const ImagePairs pairs = Pair(names, /*stamped=*/false, options, dataset);
  std::vector<std::pair<fs::path, fs::path>> mates;
  for (const ImagePair& pair : pairs.pairs) {
    mates.emplace_back(pair.images[0].path, pair.images[1].path);
  }
  std::sort(mates.begin(), mates.end());
  TakeTimes(times, names, 0, first_number, dataset);
  for (const KeyedImage& image : names.images[0]) {
    const auto mate =
        std::lower_bound(mates.begin(), mates.end(), std::pair(image.path, fs::path()));
    if (mate != mates.end() && mate->first == image.path) {
      dataset.entries.push_back({image.key, {mate->first, mate->second}});
    }
  }
  if (dataset.entries.empty()) {
    throw Error(times.path.string() + ": has no time of a left image that has a mate");
  }
}

// No times at all: number after number at a rate.
void AddNumbered(const ImageNames& names, const DatasetOptions& options, Dataset& dataset) {
  const ImagePairs pairs = Pair(names, /*stamped=*/false, options, dataset);
  const int64_t first = FirstKey(names);
  const int64_t step = NumberStep(names);
  const double rate_hz = options.rate_hz.value_or(kAssumedRateHz);
  AddEntries(pairs, dataset);
  for (Dataset::Entry& entry : dataset.entries) {
    const int64_t number = (entry.timestamp_ns - first) / step;
    entry.timestamp_ns = std::llround(static_cast<double>(number) * 1e9 / rate_hz);
  }
  if (!options.rate_hz) {
    dataset.warnings.emplace_back(
        "neither names nor a times file give times: 10 images a second are assumed (--rate HZ); "
        "times are read from .txt and .csv files whose name has \"time\" or \"stamp\", or which "
        "name "
        "the images");
  }
}

void AddImages(const PlainImages& found, const DatasetOptions& options, Dataset& dataset) {
  ImageNames names = ReadImageNames(ListPlainImages(found));
  if (!names.others.empty()) {
    dataset.images_left_out += static_cast<int>(names.others.size());
    dataset.warnings.push_back(Counted(names.others.size(), "image") +
                               " named unlike the others left out (the first is " +
                               names.others.front().string() + ")");
  }
  const auto files = FindTimesFiles(dataset.root, found.folders);
  if (names.kind == KeyKind::kStamps) {
    if (!names.unit.empty()) {
      dataset.notes.push_back("the names of the images are times in " + names.unit);
    }
    for (const auto& file : files) {
      if (file) {
        dataset.notes.push_back(file->string() +
                                " is not used: the names of the images are their times");
      }
    }
    AddStamped(names, options, dataset);
    return;
  }
  const std::optional<fs::path> left = files[0] ? files[0] : files[2];
  if (!left && !files[1]) {
    AddNumbered(names, options, dataset);
    return;
  }
  const TimesFile times = ReadTimesFile(left ? *left : *files[1]);
  NoteTimes(times, dataset);
  if (!files[0] || !files[1]) {
    AddTimed(std::move(names), times, options, dataset);
    return;
  }
  const TimesFile right_times = ReadTimesFile(*files[1]);
  NoteTimes(right_times, dataset);
  const int64_t first_number = FirstKey(names);
  TakeTimes(times, names, 0, first_number, dataset);
  TakeTimes(right_times, names, 1, first_number, dataset);
  AddStamped(names, options, dataset);
}

}  // namespace

bool IsPlain(const fs::path& root) { return FindPlainImages(root).has_value(); }

Dataset OpenPlain(const fs::path& root, const DatasetOptions& options) {
  const auto found = FindPlainImages(root);
  if (!found) {
    throw Error(root.string() +
                ": no two folders of images in it, expected left and right, cam0 and cam1, "
                "image_0 and image_1, or the like, or images whose names tell left from right");
  }
  Dataset dataset;
  dataset.root = root;
  dataset.format = DatasetFormat::kPlain;
  if (!found->note.empty()) {
    dataset.notes.push_back(found->note);
  }
  // What is wrong with the images first: they are what was named.
  AddImages(*found, options, dataset);
  if (!options.calibration) {
    throw Error(root.string() + ": a plain data set needs a calibration file (--calibration)");
  }
  SetCalibration(CalibrationFiles(options), dataset);
  AddGroundtruth(options, {}, {}, dataset);
  AddImu(options, EurocImuFiles(root), dataset);
  return dataset;
}

}  // namespace gluevo::vo
