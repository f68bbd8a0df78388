#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace gluevo::apps {

/// All image files below a folder, in the order of their paths. Throws Error where there are none.
std::vector<std::filesystem::path> ListImagesBelow(const std::filesystem::path& folder);

/// An image file as CV_8UC1. Throws Error naming the file where it cannot be read.
cv::Mat ReadGrayImage(const std::filesystem::path& file);

}  // namespace gluevo::apps
