#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "gluevo/vo/frontend/matcher.h"

namespace gluevo::vo {

/// Remembers what an extractor found in the newest images, so that a second user of them has it for
/// nothing: loops, after the front end.
class ExtractorMemo final : public FeatureExtractor {
 public:
  explicit ExtractorMemo(std::unique_ptr<FeatureExtractor> extractor);

  std::string Name() const override { return extractor_->Name(); }
  nn::Features Extract(const cv::Mat& image) override;
  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& pixels) override;

  /// What Extract would give, where that is remembered. May be called while others extract.
  std::optional<nn::Features> Known(const cv::Mat& image) const;

 private:
  std::unique_ptr<FeatureExtractor> extractor_;
  mutable std::mutex mutex_;                             // Of what follows.
  std::deque<std::pair<cv::Mat, nn::Features>> newest_;  // With copies of the images.
};

/// The same extractor for one more owner.
class SharedExtractor final : public FeatureExtractor {
 public:
  explicit SharedExtractor(std::shared_ptr<FeatureExtractor> extractor);

  std::string Name() const override { return extractor_->Name(); }
  nn::Features Extract(const cv::Mat& image) override { return extractor_->Extract(image); }
  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& pixels) override {
    return extractor_->Describe(image, pixels);
  }

 private:
  std::shared_ptr<FeatureExtractor> extractor_;
};

}  // namespace gluevo::vo
