#pragma once

#include <deque>
#include <memory>
#include <utility>

#include "gluevo/vo/frontend/matcher.h"

namespace gluevo::vo {

/// Remembers what an extractor found in the newest images, so that a second user of them has it for
/// nothing: loops, after the front end. Not to be used from several threads at once.
class ExtractorMemo final : public FeatureExtractor {
 public:
  explicit ExtractorMemo(std::unique_ptr<FeatureExtractor> extractor);

  std::string Name() const override { return extractor_->Name(); }
  nn::Features Extract(const cv::Mat& image) override;
  nn::Features Describe(const cv::Mat& image, const nn::Features::Points& pixels) override;

 private:
  std::unique_ptr<FeatureExtractor> extractor_;
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
