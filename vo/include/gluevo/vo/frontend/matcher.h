#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "gluevo/nn/features.h"

namespace gluevo::vo {

/// Finds and describes points of an image. What the front ends know of SuperPoint and ALIKED.
class FeatureExtractor {
 public:
  FeatureExtractor() = default;
  FeatureExtractor(const FeatureExtractor&) = delete;
  FeatureExtractor& operator=(const FeatureExtractor&) = delete;
  virtual ~FeatureExtractor() = default;

  /// What its time is listed under (TrackedFrame::stages_ms).
  virtual std::string Name() const { return "features"; }

  /// `image`: CV_8UC1. Throws Error for images it cannot process.
  virtual nn::Features Extract(const cv::Mat& image) = 0;

  /// Describes given points of an image, N x 2 pixels. Throws Error as Extract does.
  virtual nn::Features Describe(const cv::Mat& image, const nn::Features::Points& pixels) = 0;
};

/// Matches the points of two images. What the front ends know of SuperGlue and LightGlue.
class Matcher {
 public:
  Matcher() = default;
  Matcher(const Matcher&) = delete;
  Matcher& operator=(const Matcher&) = delete;
  virtual ~Matcher() = default;

  /// Matches with a confidence above `threshold`, 0 to 1; each keypoint of either image has at most
  /// one. Throws Error for descriptors it cannot match.
  virtual nn::Matches Match(const nn::Features& features0, const nn::Features& features1,
                            float threshold) = 0;
};

}  // namespace gluevo::vo
