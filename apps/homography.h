#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "gluevo/nn/features.h"

namespace gluevo::apps {

/// A 3 x 3 matrix in an OpenCV yaml or xml file, or nine numbers in a text file. Throws Error where
/// there is none, and where it has no inverse.
cv::Matx33d ReadHomography(const std::filesystem::path& path);

/// Matches whose point of image 0 the homography takes to within `max_error_px` of its mate.
int CountNear(const nn::Features& features0, const nn::Features& features1,
              const nn::Matches& matches, const cv::Matx33d& homography, double max_error_px);

}  // namespace gluevo::apps
