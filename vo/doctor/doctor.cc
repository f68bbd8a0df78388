#include "gluevo/vo/doctor/doctor.h"

#include <algorithm>

#include "checks.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/io/image_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

void Append(Findings more, Findings& findings) {
  findings.insert(findings.end(), std::make_move_iterator(more.begin()),
                  std::make_move_iterator(more.end()));
}

const char* LayoutName(DatasetFormat format) {
  switch (format) {
    case DatasetFormat::kEuroc:
      return "EuRoC or TUM-VI";
    case DatasetFormat::kKittiOdometry:
      return "KITTI odometry";
    case DatasetFormat::kKittiRaw:
      return "KITTI raw";
    case DatasetFormat::kPlain:
      return "two folders of images";
    default:
      return "another";
  }
}

/// Indices of at most `most` of `count`, evenly, the first and the last among them.
std::vector<std::size_t> Sample(std::size_t count, std::size_t most) {
  std::vector<std::size_t> indices;
  const std::size_t samples = std::min(count, most);
  for (std::size_t i = 0; i < samples; ++i) {
    indices.push_back(samples < 2 ? 0 : i * (count - 1) / (samples - 1));
  }
  return indices;
}

/// The images of some frames, and features that they share.
struct Samples {
  std::vector<StereoFrame> pairs;
  std::vector<cv::Mat> followers;
  std::vector<std::vector<PixelMatch>> matches;  ///< Of pairs that have enough.
};

void AddMatches(Samples& samples, Findings& findings) {
  std::vector<double> counts;
  for (const StereoFrame& pair : samples.pairs) {
    std::vector<PixelMatch> matches = MatchFeatures(pair.images[0], pair.images[1]);
    counts.push_back(static_cast<double>(matches.size()));
    if (!matches.empty()) {
      samples.matches.push_back(std::move(matches));
    }
  }
  const std::size_t with_matches = samples.matches.size();
  const Verdict verdict = 2 * with_matches >= samples.pairs.size() ? Verdict::kGood
                          : with_matches > 0                       ? Verdict::kSuspicious
                                                                   : Verdict::kWrong;
  findings.push_back({verdict, "matched features",
                      "in " + std::to_string(with_matches) + " of " +
                          std::to_string(samples.pairs.size()) + " pairs, median " +
                          FixedText(Median(std::move(counts)), 0),
                      "15 or more in most pairs: do both cameras see the same?"});
}

Samples ReadSamples(const Dataset& dataset, const DoctorOptions& options, Findings& findings) {
  Samples samples;
  std::size_t unreadable = 0;
  std::string why;
  const std::vector<std::size_t> indices =
      Sample(dataset.entries.size(), static_cast<std::size_t>(options.pairs));
  for (const std::size_t index : indices) {
    try {
      samples.pairs.push_back(dataset.Read(index));
    } catch (const Error& error) {
      why = unreadable++ == 0 ? std::string(": ") + error.what() : why;
      continue;
    }
    samples.followers.push_back(
        index + 1 < dataset.entries.size()
            ? ReadLooseImage(dataset.entries[index + 1].images[0], dataset.gray_bits)
            : cv::Mat());
  }
  findings.push_back({unreadable == 0 ? Verdict::kGood : Verdict::kWrong, "images",
                      std::to_string(indices.size() - unreadable) + " of " +
                          std::to_string(indices.size()) + " pairs looked at" + why,
                      unreadable == 0 ? "" : "images of the calibration's size that can be read"});
  return samples;
}

/// Images without a calibration, for the verdicts that need none.
void ExamineLoose(const fs::path& root, const DoctorOptions& options, Findings& findings) {
  const std::optional<LooseImages> images = FindLooseImages(root);
  if (!images) {
    return;
  }
  const std::size_t left = images->files[0].size();
  const std::size_t right = images->files[1].size();
  findings.push_back({left == right ? Verdict::kGood : Verdict::kSuspicious, "image files",
                      std::to_string(left) + " left, " + std::to_string(right) + " right",
                      "as many on both sides"});
  const std::array<int, 2> gray_bits = {GrayBits(images->files[0]), GrayBits(images->files[1])};
  Samples samples;
  std::string sizes;
  for (const std::size_t index :
       Sample(std::min(left, right), static_cast<std::size_t>(options.pairs))) {
    StereoFrame pair;
    for (std::size_t side = 0; side < 2; ++side) {
      pair.images[side] = ReadLooseImage(images->files[side][index], gray_bits[side]);
    }
    if (pair.images[0].empty() || pair.images[1].empty()) {
      const std::size_t side = pair.images[0].empty() ? 0 : 1;
      findings.push_back({Verdict::kWrong, "image", images->files[side][index].string(),
                          "an image that can be read"});
      continue;
    }
    if (sizes.empty()) {
      sizes = std::to_string(pair.images[0].cols) + " x " + std::to_string(pair.images[0].rows) +
              " left, " + std::to_string(pair.images[1].cols) + " x " +
              std::to_string(pair.images[1].rows) + " right";
      findings.push_back(
          {pair.images[0].size() == pair.images[1].size() ? Verdict::kGood : Verdict::kSuspicious,
           "image size", sizes, "the same on both sides"});
    }
    samples.pairs.push_back(std::move(pair));
  }
  if (!samples.pairs.empty()) {
    Append(CheckImages(samples.pairs, {}), findings);
    AddMatches(samples, findings);
    if (!samples.matches.empty()) {
      Append(CheckPixels(samples.matches), findings);
    }
  }
}

void ExamineOpened(const Dataset& dataset, const DoctorOptions& options, Findings& findings) {
  findings.push_back({Verdict::kGood, "layout", LayoutName(dataset.format), ""});
  findings.push_back({Verdict::kGood, "stereo pairs", std::to_string(dataset.entries.size()), ""});
  for (const std::string& note : dataset.notes) {
    findings.push_back({Verdict::kGood, "on opening", note, ""});
  }
  for (const std::string& warning : dataset.warnings) {
    findings.push_back({Verdict::kSuspicious, "on opening", warning, ""});
  }
  std::vector<int64_t> times_ns;
  for (const Dataset::Entry& entry : dataset.entries) {
    times_ns.push_back(entry.timestamp_ns);
  }
  Append(CheckStamps(times_ns), findings);
  Append(CheckRig(dataset.rig), findings);
  Samples samples = ReadSamples(dataset, options, findings);
  if (!samples.pairs.empty()) {
    Append(CheckImages(samples.pairs, samples.followers), findings);
    AddMatches(samples, findings);
    if (!samples.matches.empty()) {
      Append(CheckCalibration(dataset.rig, samples.matches), findings);
    }
  }
  Append(CheckImu(dataset.imu, times_ns), findings);
  Append(CheckGroundtruth(dataset.groundtruth, times_ns), findings);
}

}  // namespace

std::string NameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood:
      return "good";
    case Verdict::kSuspicious:
      return "suspicious";
    case Verdict::kWrong:
      break;
  }
  return "wrong";
}

Verdict UpTo(double value, double good, double suspicious) {
  if (value <= good) {
    return Verdict::kGood;
  }
  return value <= suspicious ? Verdict::kSuspicious : Verdict::kWrong;
}

void DoctorOptions::Validate() const {
  if (pairs < 1) {
    throw OptionError("number of pairs " + std::to_string(pairs) +
                      " is out of range: expected at least 1 (--pairs)");
  }
}

std::size_t Diagnosis::Count(Verdict verdict) const {
  return static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(),
                    [&](const Finding& finding) { return finding.verdict == verdict; }));
}

Diagnosis Examine(const fs::path& root, const DatasetOptions& dataset_options,
                  const DoctorOptions& options) {
  options.Validate();
  dataset_options.Validate();
  Diagnosis diagnosis;
  std::optional<Dataset> dataset;
  try {
    dataset = OpenDataset(root, dataset_options);
  } catch (const Error& error) {
    diagnosis.findings.push_back(
        {Verdict::kWrong, "opening", error.what(), "a data set as docs/DATASETS.md describes"});
  }
  if (dataset) {
    ExamineOpened(*dataset, options, diagnosis.findings);
  } else {
    ExamineLoose(root, options, diagnosis.findings);
    Append(CheckImu(FindImu(root), {}), diagnosis.findings);
  }
  return diagnosis;
}

}  // namespace gluevo::vo
