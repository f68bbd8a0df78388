// A data set's rig and its images belong together.

#include <algorithm>

#include "dataset_formats.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/calibration.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

/// The size of an image; nothing where it cannot be read, which is for the one who needs it to say.
std::optional<std::array<int, 2>> SizeIfReadable(const fs::path& image) {
  try {
    return ImageSize(image);
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

std::string WrongSizeMessage(const fs::path& image, const std::array<int, 2>& size,
                             const Camera& camera, const fs::path& calibration) {
  return image.string() + ": an image of " + std::to_string(size[0]) + " x " +
         std::to_string(size[1]) + " pixels, expected " + std::to_string(camera.width) + " x " +
         std::to_string(camera.height) +
         (calibration.empty() ? "" : ", the size in the calibration " + calibration.string());
}

void CheckCalibration(const Dataset& dataset) {
  const std::string what =
      (dataset.calibration.empty() ? dataset.root : dataset.calibration).string();
  dataset.rig.Validate(what);
  // One odd image among others is for Read to refuse; here it is the first, the last and one
  // between.
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
                    ? WrongSizeMessage(entry.images[side], *size, camera, dataset.calibration)
                    : message;
    }
  }
  if (!message.empty()) {
    throw Error(message);
  }
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
  const Calibration calibration = ReadCalibration(files, FirstImageSize(dataset));
  dataset.rig = calibration.rig;
  dataset.calibration = calibration.files.front();
  // What is of one file of several says so itself.
  const auto named = [&](const std::string& text) {
    const bool is_named =
        std::any_of(calibration.files.begin(), calibration.files.end(),
                    [&](const fs::path& file) { return text.starts_with(file.string() + ": "); });
    return (is_named ? "" : dataset.calibration.string() + ": ") + text;
  };
  for (const std::string& note : calibration.notes) {
    dataset.notes.push_back(named(note));
  }
  for (const std::string& warning : calibration.warnings) {
    dataset.warnings.push_back(named(warning));
  }
}

}  // namespace gluevo::vo
