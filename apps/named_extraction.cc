#include "named_extraction.h"

#include "gluevo/nn/error.h"

namespace gluevo::apps {

nn::Features ExtractNamed(vo::FeatureExtractor& extractor, const cv::Mat& image,
                          const std::filesystem::path& file) {
  try {
    return extractor.Extract(image);
  } catch (const Error& error) {
    throw Error(file.string() + ": " + error.what());
  }
}

}  // namespace gluevo::apps
