#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "gluevo/nn/features.h"

namespace gluevo::apps {

/// Throws Error where no picture can be put at `path`: before there is something to draw.
void CheckPlaceForDrawing(const std::filesystem::path& path);

/// Writes both images side by side with a line a match, green for sure ones to red. Throws Error
/// where it cannot be written.
void DrawMatches(const std::filesystem::path& path, const cv::Mat& image0, const cv::Mat& image1,
                 const nn::Features& features0, const nn::Features& features1,
                 const nn::Matches& matches);

}  // namespace gluevo::apps
