#include "gluevo/vo/frontend/feature_files.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/hdf5_file.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kMostKeypoints = int64_t{1} << 20;
constexpr int64_t kMostDescriptorValues = int64_t{1} << 28;

/// HDF5 takes "." for the group itself and swallows empty parts, so such a name would end up
/// elsewhere; ".." HDF5 would keep, but not whoever takes the name for a path.
void CheckName(const std::string& name) {
  std::string_view rest = name;
  while (true) {
    const std::size_t end = rest.find('/');
    const std::string_view part = rest.substr(0, end);
    if (part.empty() || part == "." || part == ".." || part.find('\0') != std::string_view::npos) {
      throw Error("image name " + Quoted(name) +
                  " cannot name a group of an HDF5 file; expected a relative path without empty, "
                  "\".\" or \"..\" parts");
    }
    if (end == std::string_view::npos) return;
    rest = rest.substr(end + 1);
  }
}

std::string Dashed(std::string name) {
  std::replace(name.begin(), name.end(), '/', '-');
  return name;
}

std::string PairName(const std::string& image0, const std::string& image1) {
  CheckName(image0);
  CheckName(image1);
  return Dashed(image0) + "/" + Dashed(image1);
}

void CheckCount(const internal::H5InputFile& file, const std::string& dataset, int64_t actual,
                int64_t expected) {
  if (actual != expected) {
    throw Error(file.Place(dataset) + " is of " + std::to_string(actual) + " values, expected " +
                std::to_string(expected) + " as there are keypoints");
  }
}

}  // namespace

FeatureWriter::FeatureWriter(const std::filesystem::path& path) : file_(internal::CreateH5(path)) {}
void FeatureWriter::Add(const std::string& image, const nn::Features& features) {
  CheckName(image);
  if (features.scores.size() != features.keypoints.rows() ||
      features.descriptors.rows() != features.keypoints.rows()) {
    throw Error("features of image " + Quoted(image) + " have " +
                std::to_string(features.keypoints.rows()) + " keypoints, " +
                std::to_string(features.scores.size()) + " scores and " +
                std::to_string(features.descriptors.rows()) +
                " descriptors, expected as many of each");
  }
  const auto count = static_cast<hsize_t>(features.keypoints.rows());
  const auto depth = static_cast<hsize_t>(features.descriptors.cols());
  const nn::Features::RowMajor by_channel = features.descriptors.transpose();
  const std::array<int64_t, 2> size = {features.width, features.height};
  file_->MakeGroup(image, "keypoints");
  file_->Write(image + "/keypoints", {count, 2}, features.keypoints.data());
  file_->Write(image + "/scores", {count}, features.scores.data());
  file_->Write(image + "/descriptors", {depth, count}, by_channel.data());
  file_->Write(image + "/image_size", {2}, size.data());
}

void FeatureWriter::Finish() { file_->Finish(); }

FeatureReader::FeatureReader(const std::filesystem::path& path)
    : file_(internal::OpenH5(path)), images_(file_->GroupsWith("keypoints")) {}
bool FeatureReader::Has(const std::string& image) const {
  return std::binary_search(images_.begin(), images_.end(), image);
}

nn::Features FeatureReader::Read(const std::string& image) const {
  if (!Has(image)) throw Error(file_->Place(image) + " is not there: no features of such an image");
  nn::Features features;

  const std::string keypoints = image + "/keypoints";
  const std::vector<int64_t> shape = file_->ShapeOf(keypoints, 2, kMostKeypoints);
  const int64_t count = shape[0];
  if (shape[1] != 2) {
    throw Error(file_->Place(keypoints) + " has " + std::to_string(shape[1]) +
                " columns, expected 2");
  }
  const std::vector<float> pixels = file_->ReadFloats(keypoints);
  features.keypoints.resize(count, 2);
  std::copy(pixels.begin(), pixels.end(), features.keypoints.data());

  const std::string scores = image + "/scores";
  CheckCount(*file_, scores, file_->ShapeOf(scores, 1, kMostKeypoints)[0], count);
  const std::vector<float> confidences = file_->ReadFloats(scores);
  features.scores.resize(count);
  std::copy(confidences.begin(), confidences.end(), features.scores.data());

  const std::string descriptors = image + "/descriptors";
  const std::vector<int64_t> extents = file_->ShapeOf(descriptors, 2, kMostKeypoints);
  if (extents[1] != count || extents[0] * extents[1] > kMostDescriptorValues) {
    throw Error(file_->Place(descriptors) + " has shape [" + std::to_string(extents[0]) + " x " +
                std::to_string(extents[1]) + "], expected a row a channel, a column a keypoint (" +
                std::to_string(count) + ")");
  }
  const std::vector<float> by_channel = file_->ReadFloats(descriptors);
  features.descriptors =
      Eigen::Map<const nn::Features::RowMajor>(by_channel.data(), extents[0], extents[1])
          .transpose();

  const std::string image_size = image + "/image_size";
  const bool two = file_->ShapeOf(image_size, 1, kMostKeypoints)[0] == 2;
  const std::vector<int> size = two ? file_->ReadIntegers(image_size) : std::vector<int>{0, 0};
  if (size[0] <= 0 || size[1] <= 0) {
    throw Error(file_->Place(image_size) + " is malformed, expected a width and a height above 0");
  }
  features.width = size[0];
  features.height = size[1];
  return features;
}

MatchWriter::MatchWriter(const std::filesystem::path& path) : file_(internal::CreateH5(path)) {}
void MatchWriter::Add(const std::string& image0, const std::string& image1,
                      const nn::Matches& matches) {
  const std::string pair = PairName(image0, image1);
  if (matches.matches0.size() != matches.scores0.size()) {
    throw Error("matches of pair " + Quoted(pair) + " are " +
                std::to_string(matches.matches0.size()) + " with " +
                std::to_string(matches.scores0.size()) + " scores, expected as many of both");
  }
  static_assert(sizeof(int) == sizeof(int32_t));
  file_->MakeGroup(pair, "matches0");
  file_->Write(pair + "/matches0", {matches.matches0.size()}, matches.matches0.data());
  file_->Write(pair + "/matching_scores0", {matches.scores0.size()}, matches.scores0.data());
}

void MatchWriter::Finish() { file_->Finish(); }

MatchReader::MatchReader(const std::filesystem::path& path) : file_(internal::OpenH5(path)) {
  for (const std::string& group : file_->GroupsWith("matches0")) {
    const std::size_t slash = group.find('/');
    if (slash == std::string::npos || group.find('/', slash + 1) != std::string::npos) {
      throw Error(file_->Place(group) + " holds matches, expected \"NAME0/NAME1\" as its name");
    }
    pairs_.emplace_back(group.substr(0, slash), group.substr(slash + 1));
  }
  std::sort(pairs_.begin(), pairs_.end());
}
bool MatchReader::Has(const std::string& image0, const std::string& image1) const {
  return std::binary_search(pairs_.begin(), pairs_.end(),
                            std::make_pair(Dashed(image0), Dashed(image1)));
}

nn::Matches MatchReader::Read(const std::string& image0, const std::string& image1) const {
  const std::string pair = Dashed(image0) + "/" + Dashed(image1);
  if (!Has(image0, image1)) {
    throw Error(file_->Place(pair) + " is not there: no matches of such a pair");
  }
  const std::string matches0 = pair + "/matches0";
  const std::string scores0 = pair + "/matching_scores0";
  const int64_t count = file_->ShapeOf(matches0, 1, kMostKeypoints)[0];
  CheckCount(*file_, scores0, file_->ShapeOf(scores0, 1, kMostKeypoints)[0], count);
  nn::Matches matches{file_->ReadIntegers(matches0), file_->ReadFloats(scores0)};
  const auto bad = std::find_if(matches.matches0.begin(), matches.matches0.end(),
                                [](int match) { return match < -1; });
  if (bad != matches.matches0.end()) {
    throw Error(file_->Place(matches0) + " holds " + std::to_string(*bad) +
                ", expected -1 or the number of a keypoint");
  }
  return matches;
}

}  // namespace gluevo::vo
