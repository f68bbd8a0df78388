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
  // One odd image among others is for Read to refuse; here it is the first, the last and some
  // between.
  constexpr std::size_t kLooked = 5;
  const std::size_t count = dataset.entries.size();
  for (std::size_t side = 0; side < 2; ++side) {
    const Camera& camera = dataset.rig.cameras[side];
    std::string message;
    std::size_t others = 0;
    bool fits = false;
    for (std::size_t i = 0; i < std::min(count, kLooked) && !fits; ++i) {
      const std::size_t index = i * (count - 1) / std::max<std::size_t>(1, kLooked - 1);
      const fs::path& image = dataset.entries[count <= kLooked ? i : index].images[side];
      const std::optional<std::array<int, 2>> size = SizeIfReadable(image);
      fits = size == std::array{camera.width, camera.height};
      if (size && !fits && ++others == 1) {
        message = WrongSizeMessage(image, *size, camera, dataset.calibration);
      }
    }
    if (!fits && (others > 1 || (others == 1 && count == 1))) {
      throw Error(message);
    }
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
  dataset.imu_time_shift_s = calibration.imu_time_shift_s;
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
