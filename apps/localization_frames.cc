#include "localization_frames.h"

#include <algorithm>
#include <charconv>
#include <system_error>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/image_file.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

bool HasImages(const fs::path& path) {
  std::error_code code;
  return fs::is_directory(path, code) ? !vo::ListImages(path).empty() : vo::HasImageEnding(path);
}

// Nothing for names that are no nanoseconds since 1970.
std::optional<int64_t> Nanoseconds(const fs::path& image) {
  constexpr std::size_t kFewestDigits = 16;
  const std::string stem = image.stem().string();
  int64_t value = 0;
  const auto [end, failure] = std::from_chars(stem.data(), stem.data() + stem.size(), value);
  const bool is_number = failure == std::errc() && end == stem.data() + stem.size();
  return is_number && stem.size() >= kFewestDigits ? std::optional(value) : std::nullopt;
}

}  // namespace

LocalizationFrames::LocalizationFrames(const fs::path& path, const DatasetArguments& arguments,
                                       bool is_left_only, const vo::StereoRig& map_rig)
    : is_left_only_(is_left_only) {
  if (arguments.format.empty() && arguments.calibration.empty() && HasImages(path)) {
    rig_ = map_rig;
    ListImages(path);
    return;
  }
  dataset_ = vo::OpenDataset(path, MakeDatasetOptions(arguments));
  PrintNotes(*dataset_);
  rig_ = dataset_->rig;
  groundtruth_ = dataset_->groundtruth;
  for (const vo::Dataset::Entry& entry : dataset_->entries) {
    names_.push_back(entry.images[0].lexically_proximate(dataset_->root).generic_string());
    times_ns_.push_back(entry.timestamp_ns);
  }
}

void LocalizationFrames::ListImages(const fs::path& path) {
  images_ = fs::is_directory(path) ? vo::ListImages(path) : std::vector{path};
  gray_bits_ = vo::GrayBits(images_);
  const bool are_stamped = std::all_of(images_.begin(), images_.end(), Nanoseconds);
  constexpr int64_t kSecond = 1'000'000'000;
  for (std::size_t i = 0; i < images_.size(); ++i) {
    names_.push_back(images_[i].filename().string());
    times_ns_.push_back(are_stamped ? *Nanoseconds(images_[i]) : static_cast<int64_t>(i) * kSecond);
  }
}

vo::StereoFrame LocalizationFrames::Read(std::size_t index) const {
  if (dataset_) {
    vo::StereoFrame frame = dataset_->Read(index);
    if (is_left_only_) {
      frame.images[1] = cv::Mat();
    }
    return frame;
  }
  vo::StereoFrame frame{times_ns_[index], {}};
  frame.images[0] = vo::ReadGrayImage(images_[index], gray_bits_).pixels;
  const vo::Camera& camera = rig_.cameras[0];
  if (frame.images[0].cols != camera.width || frame.images[0].rows != camera.height) {
    throw Error(images_[index].string() + ": an image of " + std::to_string(frame.images[0].cols) +
                " x " + std::to_string(frame.images[0].rows) + " pixels, expected " +
                std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                " as of the map's left camera");
  }
  return frame;
}

}  // namespace gluevo::apps
