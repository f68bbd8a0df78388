#include "gluevo/vo/estimator/views_noise.h"

#include <algorithm>
#include <cmath>

namespace gluevo::vo {

void ViewsNoise::Learn(double mean_square, double freedom) {
  constexpr double kFewest = 50.0;
  if (freedom < kFewest) {
    return;
  }
  // Windows overlap, and the noise belongs to camera and front end.
  constexpr int kMost = 50;
  windows_ = std::min(windows_ + 1, kMost);
  mean_square_ += (mean_square - mean_square_) / windows_;
}

double ViewsNoise::Factor() const {
  // Views of one track err alike, in its parts that are in the prior, too, so that together they
  // say less than their residuals tell: squared errors of motions from frame to frame are up to
  // twice what the window says (BENCHMARKS.md, covariance), of longer ones more.
  constexpr double kAlike = 2.0;
  constexpr double kLeast = 0.1;
  constexpr double kMost = 10.0;
  return std::clamp(kAlike * std::sqrt(mean_square_), kLeast, kMost);
}

}  // namespace gluevo::vo
