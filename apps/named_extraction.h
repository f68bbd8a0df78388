#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "gluevo/vo/frontend/matcher.h"

namespace gluevo::apps {

/// As FeatureExtractor::Extract; its Errors name the file that the image is from.
nn::Features ExtractNamed(vo::FeatureExtractor& extractor, const cv::Mat& image,
                          const std::filesystem::path& file);

}  // namespace gluevo::apps
