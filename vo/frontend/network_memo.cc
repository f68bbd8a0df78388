#include "gluevo/vo/frontend/network_memo.h"

#include <algorithm>
#include <cstring>

namespace gluevo::vo {
namespace {

constexpr std::size_t kImages = 2;  // Left and right.

bool IsSame(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) {
    return false;
  }
  const std::size_t bytes = static_cast<std::size_t>(a.cols) * a.elemSize();
  for (int y = 0; y < a.rows; ++y) {
    if (std::memcmp(a.ptr(y), b.ptr(y), bytes) != 0) {
      return false;
    }
  }
  return true;
}

}  // namespace

ExtractorMemo::ExtractorMemo(std::unique_ptr<FeatureExtractor> extractor)
    : extractor_(std::move(extractor)) {}

nn::Features ExtractorMemo::Extract(const cv::Mat& image) {
  if (std::optional<nn::Features> known = Known(image)) {
    return *std::move(known);
  }
  nn::Features features = extractor_->Extract(image);
  const std::lock_guard lock(mutex_);
  newest_.emplace_front(image.clone(), features);
  newest_.resize(std::min(newest_.size(), kImages));
  return features;
}

std::optional<nn::Features> ExtractorMemo::Known(const cv::Mat& image) const {
  const std::lock_guard lock(mutex_);
  const auto known = std::find_if(newest_.begin(), newest_.end(), [&](const auto& remembered) {
    return IsSame(remembered.first, image);
  });
  return known == newest_.end() ? std::nullopt : std::optional(known->second);
}

nn::Features ExtractorMemo::Describe(const cv::Mat& image, const nn::Features::Points& pixels) {
  return extractor_->Describe(image, pixels);
}

SharedExtractor::SharedExtractor(std::shared_ptr<FeatureExtractor> extractor)
    : extractor_(std::move(extractor)) {}

}  // namespace gluevo::vo
