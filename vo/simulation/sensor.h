#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "gluevo/vo/simulation/simulation.h"
#include "random.h"

namespace gluevo::simulation {

/// Turns the brightness that falls on a camera into an 8-bit image, as ImageOptions say.
class Sensor {
 public:
  explicit Sensor(const ImageOptions& options);

  /// The factor by which an image at `time_s` is exposed longer or shorter: smooth in time, within
  /// `exposure_change` stops, drawn from the seed.
  double Exposure(double time_s, uint64_t seed) const;

  /// CV_8UC1 from CV_32FC1, 0 to 255. The noise is drawn from the seed alone.
  cv::Mat Expose(const cv::Mat& brightness, double exposure, uint64_t noise_seed) const;

 private:
  ImageOptions options_;
  const NormalTable& normal_;
};

}  // namespace gluevo::simulation
