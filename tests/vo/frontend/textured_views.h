#pragma once

#include <cmath>
#include <opencv2/core/mat.hpp>

namespace gluevo::vo::testing {

/// A smooth pattern with corners everywhere, seen with its origin moved to (x, y): any shift, also
/// by parts of a pixel, is exact.
inline cv::Mat PatternAt(double x, double y, int width = 64, int height = 48) {
  cv::Mat image(height, width, CV_8UC1);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const double u = column - x;
      const double v = row - y;
      const double value = std::sin(0.61 * u + 0.2 * v) + std::sin(0.47 * v - 0.13 * u) +
                           std::sin(0.29 * u - 0.37 * v + 1.0);
      image.at<unsigned char>(row, column) =
          static_cast<unsigned char>(std::lround(127.0 + 40.0 * value));
    }
  }
  return image;
}

}  // namespace gluevo::vo::testing
