#pragma once

#include <opencv2/core/types.hpp>

#include "gluevo/nn/features.h"

namespace gluevo::vo {

inline cv::Point2f PixelOf(const nn::Features& features, int keypoint) {
  return {features.keypoints(keypoint, 0), features.keypoints(keypoint, 1)};
}

}  // namespace gluevo::vo
