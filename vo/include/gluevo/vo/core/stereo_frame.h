#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace gluevo::vo {

/// One stereo pair, gray, 8 bits.
struct StereoFrame {
  int64_t timestamp_ns = 0;
  std::array<cv::Mat, 2> images;  ///< CV_8UC1, left and right, of the cameras' sizes.
};

}  // namespace gluevo::vo
