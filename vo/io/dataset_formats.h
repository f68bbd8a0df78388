#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "gluevo/vo/io/dataset.h"

// One reader a format. Each lists all frames, reads the calibration and finds the ground truth; the
// choice of frames is not theirs. A folder Is... of a format also where parts of it are missing, so
// that the reader can name them.
namespace gluevo::vo {

bool IsEuroc(const std::filesystem::path& root);
Dataset OpenEuroc(const std::filesystem::path& root, const DatasetOptions& options);

bool IsKittiOdometry(const std::filesystem::path& root);
Dataset OpenKittiOdometry(const std::filesystem::path& root, const DatasetOptions& options);

bool IsKittiRaw(const std::filesystem::path& root);
Dataset OpenKittiRaw(const std::filesystem::path& root, const DatasetOptions& options);

bool IsPlain(const std::filesystem::path& root);
Dataset OpenPlain(const std::filesystem::path& root, const DatasetOptions& options);

/// Gives a data set that has its entries the rig of calibration files, and their warnings.
void SetCalibration(const std::vector<std::filesystem::path>& files, Dataset& dataset);
/// Throws Error for a rig that cannot be, and where the images have another size than their
/// cameras.
void CheckCalibration(const Dataset& dataset);
/// The message that an image has another size than its camera.
std::string WrongSizeMessage(const std::filesystem::path& image, const std::array<int, 2>& size,
                             const Camera& camera, const std::filesystem::path& calibration);
/// The files that --calibration names; none where it is not given.
std::vector<std::filesystem::path> CalibrationFiles(const DatasetOptions& options);

/// Throws Error naming `what` unless the folder is there.
void CheckFolder(const std::filesystem::path& folder, const std::string& what);
/// Width and height of an image file. Throws Error where it cannot be read.
std::array<int, 2> ImageSize(const std::filesystem::path& file);
/// Width and height of the first left image that can be read. Throws Error naming the first one
/// where none of the first 100 can.
std::array<int, 2> FirstImageSize(const Dataset& dataset);
/// Absolute and without a slash at its end, so that parent_path() is the folder above.
std::filesystem::path FolderPath(const std::filesystem::path& folder);

}  // namespace gluevo::vo
